//! Runs headless Chromium, to view pages as readers do.
//!
//! The executable is the path in the environment variable `CHROME`, otherwise `chromium`, `chromium-browser` or `google-chrome`.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Script at the end of the page's copy: measures the page and each drawing, and sends the results to the enclosing frame.
const MEASURE: &str = r#"<script>
addEventListener("load", () => {
  const drawings = [...document.querySelectorAll("figure svg")].map(svg => svg.getBoundingClientRect());
  const flat = drawings.filter(box => !(box.width > 0 && box.height > 0)).length;
  const own = ".scroll, .drawing, .bar ul, .explore-scroll"; // boxes that scroll by themselves
  const wide = [...document.querySelectorAll("body *")].filter(it => it.getBoundingClientRect().right > innerWidth + 0.5 && !it.closest(own));
  const names = wide.slice(0, 5).map(it => it.tagName + " " + it.className).join("; ");
  const told = [innerWidth, document.documentElement.scrollWidth, drawings.length, flat, names, "END"].join("|");
  parent.postMessage("MEASURED|" + told, "*");
});
</script></body>"#;
/// A page with a frame of the requested width. The browser's window may have another width.
const FRAME: &str = r#"<!DOCTYPE html><body><iframe src="measured.html" style="width:WIDTHpx;height:900px;border:0"></iframe><script>
addEventListener("message", told => { document.body.innerText = told.data; });
</script></body>"#;

/// Path of the browser. If no browser is installed, prints a message and returns `None`, because the project does not require a browser.
pub fn browser() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome"].map(PathBuf::from);
    let candidates = std::env::var_os("CHROME").map(PathBuf::from).into_iter().chain(names);
    let runs = |name: &PathBuf| Command::new(name).arg("--version").output().is_ok_and(|out| out.status.success());
    let found = candidates.into_iter().find(runs);
    if found.is_none() {
        eprintln!("left out: no Chromium here (chromium, chromium-browser, google-chrome, or the path in CHROME)");
    }
    found
}

/// Runs the browser on a page, with a separate profile.
pub fn run(browser: &Path, page: &Path, arguments: &[&str]) -> Output {
    let profile = tempfile::tempdir().expect("a folder");
    Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--enable-logging=stderr", "--v=0"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .args(arguments)
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("the browser starts")
}

/// Checks that the page wrote nothing to the browser's console.
#[track_caller]
pub fn assert_silent(output: &Output) {
    let said = String::from_utf8_lossy(&output.stderr);
    let console: Vec<&str> = said.lines().filter(|line| line.contains("CONSOLE")).collect();
    assert!(console.is_empty(), "{console:?}");
}

/// Measurements of a page: widths of window and page, numbers of drawings and of drawings without size, and elements that are too wide.
pub struct Measured {
    pub window: f64,
    pub page: f64,
    pub drawings: usize,
    pub flat: usize,
    pub wide: String,
}

/// Measures a copy of a page in a window of the given width, with all `<details>` elements opened.
pub fn measure(browser: &Path, folder: &Path, html: &str, width: u32, dark: bool) -> Measured {
    // The `<details>` elements are opened, so that their content is measured as well.
    let page = folder.join("measured.html");
    let mut copy = html.replace("<details>", "<details open>").replace("</body>", MEASURE);
    if dark {
        copy = copy.replace("color-scheme: light dark;", "color-scheme: dark;");
    }
    std::fs::write(&page, copy).expect("a copy of the page");
    let frame = folder.join("frame.html");
    std::fs::write(&frame, FRAME.replace("WIDTH", &width.to_string())).expect("a frame");
    let output = run(browser, &frame, &["--dump-dom", "--virtual-time-budget=3000"]);
    assert_silent(&output);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let found = said.split("MEASURED|").nth(1).unwrap_or_else(|| panic!("nothing measured: {said:.500}"));
    let parts: Vec<&str> = found.split('|').collect();
    let number = |at: usize| parts[at].parse::<f64>().expect("a number");
    Measured {
        window: number(0),
        page: number(1),
        drawings: number(2) as usize,
        flat: number(3) as usize,
        wide: parts[4].to_owned(),
    }
}
