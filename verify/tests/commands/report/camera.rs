//! Tests the report's section on errors that a camera causes in displacements and forces.

use super::shared::*;

#[test]
fn what_a_camera_costs_is_in_the_report() {
    let summary = PAPERS.summary();
    let rows = array(&summary, "camera");
    assert_keys(rows, &["item", "setting"], &["force_rms_error", "force_largest_error"]);
    let number = |row: &serde_json::Value, key: &str| row[key].as_f64().expect("a number");
    for row in rows {
        // The row `mesh` states an error of the mesh, which does not depend on a camera, so this row has no displacement errors.
        let is_mesh = row["item"] == "mesh";
        for key in ["displacement_rms_mm", "displacement_largest_mm", "first_order_rms_error"] {
            assert_eq!(row[key].is_null(), is_mesh, "{key} of {row}");
        }
        assert_eq!((number(row, "found"), number(row, "refused")), (number(row, "markers"), 0.0), "{row}");
        // If displacements come from images or are relative to the seen rest shape, their errors are small, so the force error is of first order in
        // these errors. The report computes the error of the force in two ways: to first order from the finger's response, and by sensing.
        if row["in_images"] == true || row["is_rest_seen"] == true {
            let [sensed, first] = ["force_rms_error", "first_order_rms_error"].map(|key| number(row, key));
            assert!((sensed / first - 1.0).abs() < 0.02, "{row}");
        }
        // Rows without an image state no noise.
        assert_eq!(row["stated_mm"].is_null(), row["in_images"] == false, "{row}");
    }
    assert!(rows[0]["item"] == "as it is" && number(&rows[0], "displacement_rms_mm") < 0.004);
    let page = PAPERS.pages();
    let section =
        page[page.find("id=\"camera\"").expect("the section")..].split("</section>").next().unwrap_or_default();
    assert_eq!(section.matches("<svg").count(), 3);
    for said in ["the paper's camera", "In simulation", "if the whole image is searched"] {
        assert!(section.contains(said), "{said}");
    }
}
