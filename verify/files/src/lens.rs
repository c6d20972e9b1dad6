//! Reads lenses from the calibration files of other programs: `camera_info` of ROS (YAML), and OpenCV's storage (YAML, XML or JSON).

use super::{FileError, read_text};
use finray_model::camera::{Distortion, Lens};
use std::path::Path;
use yaml_rust2::{Yaml, YamlLoader};

/// Names of the entries that describe a lens, in lower case without `_`. The first name of each list stands in messages.
const WIDTH: &[&str] = &["imagewidth", "width"];
const HEIGHT: &[&str] = &["imageheight", "height"];
const MATRIX: &[&str] = &["cameramatrix", "k", "mtx"];
const DISTORTION: &[&str] = &["distortioncoefficients", "d", "distcoeffs", "distcoeff", "dist"];
const MODEL: &[&str] = &["distortionmodel"];
const FISHEYE: &[&str] = &["fisheyemodel"];
/// Names of distortion models with the coefficients k1, k2, p1, p2, k3, k4, k5, k6.
const BROWN_CONRADY: [&str; 2] = ["plumb_bob", "rational_polynomial"];
/// Names of the fisheye model with the coefficients k1, k2, k3, k4.
const EQUIDISTANT: [&str; 2] = ["equidistant", "fisheye"];

/// Reads a lens from a `camera_info` file of ROS, or from a file that OpenCV's `FileStorage` wrote.
///
/// # Errors
/// [`FileError`] if the file cannot be read, has another form, lacks the size of the image, or states another distortion than [`Distortion`]: another
/// model, a thin prism, a tilted sensor, or a skew.
pub fn load_lens(path: &Path) -> Result<Lens, FileError> {
    let text = read_text(path)?;
    lens(&text).map_err(|reason| FileError::content(path, reason))
}

/// Name of an entry, in lower case without `_`, and its words and numbers.
type Entry = (String, Vec<String>);

fn lens(text: &str) -> Result<Lens, String> {
    let entries = if text.trim_start().starts_with('<') { of_xml(text)? } else { of_yaml(text)? };
    let entry =
        |names: &[&str]| entries.iter().find(|(name, _)| names.contains(&name.as_str())).map(|(_, words)| words);
    let numbers = |names: &[&str], label: &str| {
        let words =
            entry(names).ok_or_else(|| format!("expected {label}, as in a camera_info of ROS or a file of OpenCV"))?;
        let numbers: Result<Vec<f64>, _> = words.iter().map(|word| word.parse()).collect();
        numbers.map_err(|_| format!("{label}: expected numbers, found {:?}", words.join(" ")))
    };
    let side = |names: &[&str], label: &str| match numbers(names, label)?[..] {
        [side] if side > 0.0 && side.fract() == 0.0 => Ok(side as u32),
        _ => Err(format!("{label}: expected a number of pixels")),
    };
    let size_px = [side(WIDTH, "image_width")?, side(HEIGHT, "image_height")?];
    let matrix = numbers(MATRIX, "camera_matrix")?;
    let [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0] = matrix[..] else {
        return Err(format!("camera_matrix: expected fx, 0, cx, 0, fy, cy, 0, 0, 1, found {matrix:?}"));
    };
    let model = entry(MODEL).map_or_else(String::new, |words| words.concat());
    let is_fisheye = entry(FISHEYE).is_some_and(|words| !matches!(&*words.concat(), "0" | "false"));
    let is_fisheye = is_fisheye || EQUIDISTANT.contains(&model.as_str());
    if !(is_fisheye || model.is_empty() || BROWN_CONRADY.contains(&model.as_str())) {
        let known = [BROWN_CONRADY, EQUIDISTANT].concat().join(", ");
        return Err(format!("distortion_model: expected one of {known}, found {model:?}"));
    }
    let coefficients = numbers(DISTORTION, "distortion_coefficients")?;
    let distortion = if is_fisheye { Distortion::fisheye(&coefficients) } else { Distortion::rational(&coefficients) };
    let distortion = distortion.map_err(|error| format!("distortion_coefficients: expected {error}"))?;
    Lens::new(size_px, [fx, fy], [cx, cy], distortion).map_err(|error| error.to_string())
}

fn plain(name: &str) -> String {
    name.to_ascii_lowercase().replace('_', "")
}

fn of_yaml(text: &str) -> Result<Vec<Entry>, String> {
    // OpenCV writes its version of YAML as "%YAML:1.0", which is not a directive of YAML.
    let text: String = text.lines().filter(|line| !line.starts_with("%YAML")).flat_map(|line| [line, "\n"]).collect();
    let documents = YamlLoader::load_from_str(&text).map_err(|error| format!("expected YAML, XML or JSON: {error}"))?;
    let entries = documents.into_iter().next().and_then(Yaml::into_hash);
    let entries = entries.ok_or("expected entries such as image_width and camera_matrix")?;
    // Matrices are entries with `data`, or lists of numbers or of rows.
    let data = |value: &Yaml| words(if value["data"].is_badvalue() { value } else { &value["data"] });
    Ok(entries.iter().filter_map(|(name, value)| Some((plain(name.as_str()?), data(value)))).collect())
}

fn words(value: &Yaml) -> Vec<String> {
    match value {
        Yaml::Array(values) => values.iter().flat_map(words).collect(),
        Yaml::Real(text) | Yaml::String(text) => vec![text.clone()],
        Yaml::Integer(number) => vec![number.to_string()],
        Yaml::Boolean(switch) => vec![switch.to_string()],
        _ => Vec::new(),
    }
}

fn of_xml(text: &str) -> Result<Vec<Entry>, String> {
    let document = roxmltree::Document::parse(text).map_err(|error| format!("expected XML: {error}"))?;
    let entries = document.root_element().children().filter(roxmltree::Node::is_element).map(|entry| {
        let data = entry.children().find(|node| node.has_tag_name("data")).unwrap_or(entry);
        let words = data.text().unwrap_or_default().split_whitespace().map(str::to_owned).collect();
        (plain(entry.tag_name().name()), words)
    });
    Ok(entries.collect())
}
