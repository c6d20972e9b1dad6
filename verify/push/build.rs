//! Digest of the code that `push.wasm` contains, so that the crate knows whether the committed program was built from the present code.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// Folders of the code.
const SOURCES: [&str; 3] = ["src", "../../model/src", "../../model/numerics/src"];

fn main() -> io::Result<()> {
    let mut files = Vec::new();
    // A published package lacks the folders of the other crates; its program is the one that was published with it.
    let is_published = !Path::new(SOURCES[1]).exists();
    for folder in SOURCES.iter().filter(|_| !is_published) {
        println!("cargo::rerun-if-changed={folder}");
        collect(Path::new(folder), &mut files)?;
    }
    files.sort();
    // FNV-1a of all lines of code. Comments and indentation do not change the program.
    let mut digest = 0xcbf2_9ce4_8422_2325_u64;
    for file in &files {
        let text = fs::read_to_string(file)?;
        let code = text.lines().map(str::trim).filter(|line| !line.starts_with("//"));
        for byte in code.flat_map(|line| line.bytes().chain([b'\n'])) {
            digest = (digest ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    }
    let digest = if is_published { fs::read_to_string("push.digest")? } else { format!("{digest:016x}\n") };
    fs::write(Path::new(&env::var("OUT_DIR").map_err(io::Error::other)?).join("push.digest"), digest)
}

/// All Rust files of a folder and of its subfolders.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    Ok(())
}
