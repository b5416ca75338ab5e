//! The fuzz target on its seed corpus, whole, cut off and with single bytes changed: nothing panics.

#[path = "support/fuzz_scenario.rs"]
mod fuzz_scenario;

#[test]
fn the_seed_corpus_runs() {
    let corpus = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus/scenario");
    let files: Vec<_> = std::fs::read_dir(corpus).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(files.len() >= 6, "seeds are missing");
    for file in files {
        println!("{}", file.display());
        let seed = std::fs::read(file).unwrap();
        fuzz_scenario::run(&seed);
        for at in 0..seed.len() {
            fuzz_scenario::run(&seed[..at]);
            let mut changed = seed.clone();
            for byte in [b'9', b'-', b'[', b'"', b'=', b'\n'] {
                changed[at] = byte;
                fuzz_scenario::run(&changed);
            }
        }
    }
}
