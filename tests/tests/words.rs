//! Sentences of the claims: the code uses exactly the sentences that `words.toml` defines.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Quoted words that follow one of the `beginnings`, in all Rust files of a folder.
fn said(folder: &Path, beginnings: &[&str]) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(said(&path, beginnings));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text: String = fs::read_to_string(&path).expect("a file of text").split_whitespace().collect();
            for beginning in beginnings {
                let quoted = text.split(beginning).skip(1).filter_map(|after| after.split('"').next());
                found.extend(quoted.map(str::to_owned));
            }
        }
    }
    found
}

#[test]
fn every_claim_is_written_and_made() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../verify/studies/src/claims");
    let written = fs::read_to_string(folder.join("words.toml")).expect("a file of text");
    let written: toml::Table = written.parse().expect("a table");
    let names = written.iter().filter(|(_, claim)| claim.is_table()).map(|(name, _)| name.clone());
    assert_eq!(said(&folder, &["words.claim(\"", "row(\""]), names.collect());
}
