//! The user guides, one page per task. `finray guide TOPIC` prints a page; its console examples run as tests.

/// One page of the guide.
#[derive(Debug, Clone, Copy)]
pub struct Guide {
    /// Topic name, the argument of `finray guide`.
    pub name: &'static str,
    /// Task that the page explains, in one line.
    pub task: &'static str,
    /// Text of the page, Markdown.
    pub text: &'static str,
}

/// Declares one documented module per page, and the list `GUIDES` of all pages.
macro_rules! guides {
    ($($module:ident, $name:literal: $task:literal;)*) => {
        $(
            #[doc = include_str!(concat!("../guide/", $name, ".md"))]
            pub mod $module {}
        )*

        /// All guides, in the order in which a new user needs them.
        pub const GUIDES: &[Guide] =
            &[$(Guide { name: $name, task: $task, text: include_str!(concat!("../guide/", $name, ".md")) }),*];
    };
}

guides! {
    printed_finger, "printed-finger": "Lead from a printed finger, a drawing and photographs to forces";
    your_finger, "your-finger": "Describe your finger in a scene file and deform it";
    sense, "sense": "Estimate contact forces from displacements, with their uncertainty";
    photographs, "photographs": "Estimate a force from an image of the markers";
    live, "live": "Sense the forces in a camera's stream";
    python, "python": "Use solver, marker locator and sensors from Python";
    calibrate, "calibrate": "Find moduli, geometry and friction of a real finger";
    lens, "lens": "Calibrate a camera's lens from images of a grid";
    maps_and_sweeps, "maps-and-sweeps": "Map where a finger senses forces reliably";
    clusters, "clusters": "Divide a large map or sweep among many machines";
    press_and_grasp, "press-and-grasp": "Press an object onto one finger, or grasp it with two fingers";
    networks, "networks": "Train a sensing network, or use a shipped one";
    reading_the_report, "reading-the-report": "Make the report and read it";
    accuracy, "accuracy": "How accurate forces are: photographs, images, simulation";
    architecture, "architecture": "How the program is divided into parts, and where to add code";
    files, "files": "Columns of every file that a command reads or writes";
}
