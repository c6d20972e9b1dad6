//! Sentences of the page and of the claims: the code uses exactly the sentences that the `words.toml` files define.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Names of the sentences in a table of them, by section or claim.
fn written(path: &Path) -> toml::Table {
    fs::read_to_string(path).expect("a file of text").parse().expect("a table")
}

/// Words in quotation marks behind some beginnings, in all files of a folder.
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

fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../verify").join(name)
}

#[test]
fn every_sentence_of_the_page_is_written_and_said() {
    let folder = source("report/src");
    let sections = written(&folder.join("words.toml"));
    let names = sections.iter().flat_map(|(section, sentences)| {
        let sentences = sentences.as_table().expect("sentences").keys();
        sentences.map(move |name| format!("{section}.{name}"))
    });
    assert_eq!(said(&folder, &["say(\"", "paragraph(\""]), names.collect());
}

#[test]
fn every_claim_is_written_and_made() {
    let folder = source("studies/src/claims");
    let written = written(&folder.join("words.toml"));
    let names = written.iter().filter(|(_, claim)| claim.is_table()).map(|(name, _)| name.clone());
    assert_eq!(said(&folder, &["words.claim(\"", "row(\""]), names.collect());
}
