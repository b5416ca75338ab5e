//! Time stepping of the robots: against another simulator, and by the laws that it must keep.
mod absolute;
mod another_simulator;
mod energy;
mod humanoid;
mod in_process;
mod laws;
