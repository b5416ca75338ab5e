//! The fuzz target on its seed corpus: nothing panics.

#[test]
fn the_seed_corpus_runs() {
    let corpus = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus/log");
    let files: Vec<_> = std::fs::read_dir(corpus).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(files.len() > 20, "seeds are missing");
    for file in files {
        println!("{}", file.display());
        crate::logs::fuzz_log::run(&std::fs::read(file).unwrap());
    }
}
