//! Any bytes as a log with any names.
#![no_main]
use libfuzzer_sys::fuzz_target;

#[path = "../../tests/support/fuzz_inventory.rs"]
mod fuzz_inventory;

fuzz_target!(|data: &[u8]| {
    let folder = std::env::temp_dir().join(format!("bipedc-inventory-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a scratch folder");
    fuzz_inventory::run(data, &folder);
});
