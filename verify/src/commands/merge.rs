//! The command `finray merge`.

use super::grid::{figure, map_of, table_path, trusted};
use crate::commands::prelude::*;
use finray_files::{open_stream, streamed, write_from};
use finray_studies::sampling::sweep::Shards;
use std::io::{Read, Write};

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray map fixtures/scenes/paper.toml --shard 1/2 --out 1.csv
  finray map fixtures/scenes/paper.toml --shard 2/2 --out 2.csv
  finray merge 1.csv 2.csv --out map.csv      (and map.svg)

Guide: finray guide clusters";

/// Join the shards of `finray map` or `finray sweep` into the files of one run.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Files that `map` or `sweep` wrote with --shard, in any order
    #[arg(value_name = "SHARD", required = true)]
    shards: Vec<PathBuf>,
    /// Result file; for a map, the figure is also written, with suffix .svg; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    let shards = Shards::open(&arguments.shards)?;
    let joined = || format!("{} joined", count(arguments.shards.len(), "shard"));
    if is_stream(&arguments.out) {
        let mut stream = open_stream(&arguments.out)?;
        let copied = std::io::copy(&mut shards.table(), &mut stream);
        streamed(&arguments.out, copied.and_then(|_| stream.flush()))?;
        return Ok(summary(joined(), None::<&Path>));
    }
    let request = shards.request();
    let out = table_path(request.table, &arguments.out);
    let scene = Scene::from_toml(&request.scene)
        .map_err(|error| bad_input(format!("the scene in the shards is invalid: {error}")))?;
    let map = map_of(request, shards.table())?;
    let figure = map.as_ref().map(|map| figure(&scene.finger, map, &out)).transpose()?;
    let mut table = shards.table();
    let mut texts: Vec<&[u8]> = figure.iter().map(|(_, text)| text.as_bytes()).collect();
    let mut sources: Vec<(&Path, &mut dyn Read)> = vec![(&out, &mut table)];
    sources.extend(figure.iter().zip(&mut texts).map(|((path, _), text)| (path.as_path(), text as &mut dyn Read)));
    write_from(sources)?;
    let result = map.as_ref().map_or_else(joined, |map| format!("{}, {}", joined(), trusted(&scene, map)));
    Ok(summary(result, std::iter::once(&out).chain(figure.iter().map(|(path, _)| path))))
}
