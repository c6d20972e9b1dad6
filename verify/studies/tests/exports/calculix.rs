//! Tests that tables and manifest agree for the fingers solved as plane continua.

use finray_studies::exports::calculix::PROGRAM;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

#[test]
fn tables_hold_the_cases_of_the_manifest() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/calculix");
    let manifest: Value =
        serde_json::from_str(&fs::read_to_string(folder.join("manifest.json")).expect("a manifest")).expect("JSON");
    for exported in PROGRAM.fingers {
        let record = &manifest["tables"][exported.name];
        let cases = exported.cases().expect("a table");
        assert_eq!(record["cases"].as_u64(), Some(cases.len() as u64), "{}", exported.name);
        // Each load, angle and force is in the table, or the manifest states why it is not.
        let key = |record: &Value| ["load", "angle_deg", "force_n"].map(|key| record[key].as_f64().expect("a number"));
        let missing =
            ["no_equilibrium_found", "left_out_as_uncertain"].map(|list| record[list].as_array().expect("a list"));
        let missing: Vec<_> = missing.into_iter().flatten().map(key).collect();
        let exported_cases = cases.iter().map(|case| [case.node.0 as f64, case.angle_deg, case.force_n]);
        let all: Vec<_> = exported_cases.chain(missing).collect();
        let grid = [0, 1, 2].map(|i| all.iter().map(|case| case[i].to_bits()).collect::<BTreeSet<_>>().len());
        assert_eq!(all.len(), grid.iter().product::<usize>(), "{}: {grid:?}", exported.name);
        let stated = record["largest_uncertainty"].as_f64().expect("a number");
        let largest =
            cases.iter().map(|case| case.uncertainty_mm / case.shape.largest_displacement_mm()).fold(0.0, f64::max);
        // Tables contain uncertainties with two significant digits.
        assert!((largest / stated - 1.0).abs() < 0.05, "{}: {largest}, not {stated}", exported.name);
        assert!(cases.iter().all(|case| case.uncertainty_rad.is_none()));
    }
}
