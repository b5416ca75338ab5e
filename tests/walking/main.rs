//! Walks that `bipedc gait plan` plans: against Pinocchio, against limits that do not hold, against requests without meaning.
mod amended;
mod by_itself;
mod estimated;
mod followed;
mod on_board;
mod oracle;
mod page;
mod payload;
mod refused;
