//! Where the energy of a simulated run went, as a table.
use bipedc_analysis::simulate::EnergyBalance;
use std::fmt::Write;

/// Stored energies, works and losses in J; what is zero is left out.
pub fn table(b: &EnergyBalance) -> String {
    let mut text = String::from("energy, J                    start          end       change\n");
    // Writing to a string cannot fail.
    let stored = [
        ("kinetic", b.kinetic),
        ("potential", b.potential),
        ("rotors", b.rotors),
        ("springs of the ground", b.ground_springs),
    ];
    for (name, [start, end]) in stored.into_iter().filter(|(_, e)| *e != [0.0; 2]) {
        let _ = writeln!(text, "{name:21} {start:12.4} {end:12.4} {:12.4}", end - start);
    }
    let _ = writeln!(text, "{:21} {:38.4}", "sum", b.change());
    let flows = [
        ("work of the drives", b.drives),
        ("springs and other laws of joints", b.laws),
        ("viscous friction of joints", -b.viscous_friction),
        ("dry friction of joints", -b.dry_friction),
        ("stops of joints", -b.stops),
        ("impacts of feet", -b.impacts),
        ("sliding of feet", -b.sliding),
        ("dampers of the ground", -b.ground_dampers),
    ];
    for (name, flow) in flows.into_iter().filter(|(_, flow)| *flow != 0.0) {
        let _ = writeln!(text, "{name:34} {flow:25.4}");
    }
    let part = if b.lost > 0.0 {
        format!(" ({:.1e} of what was lost)", (b.remainder / b.lost).abs())
    } else {
        String::new()
    };
    let _ = writeln!(text, "{:34} {:25.2e}{part}", "not explained by these", b.remainder);
    text
}
