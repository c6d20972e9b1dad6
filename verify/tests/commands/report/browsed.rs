//! Tests the report's pages in a browser: window sizes, printing, the reader's choices and animated drawings.

use super::shared::*;
use crate::kit::*;
use finray_figures::{Film, Frame, Series, Shot};
use finray_report::page::{self, Block, Figure, Page, Section};
use std::path::Path;

/// A headless browser draws its window only once, so a timer triggers the frames of animations.
const FRAMES: &str = "window.requestAnimationFrame = (draw) => setTimeout(draw, 16);";

/// Runs a script that operates a page, and returns the script's results: lines that begin with PASS, FAIL or DONE.
pub fn driven(browser: &Path, html: &str, script: &str, width: u32) -> Vec<String> {
    let before = include_str!("explore/before.js");
    let folder = tempfile::tempdir().expect("a folder");
    let page = folder.path().join("driven.html");
    let (text, end) = html.rsplit_once("</body>").expect("the end of the page");
    let head = format!("<head><script>{before}{FRAMES}</script>");
    let text = format!("{text}<script>{script}</script></body>{end}").replacen("<head>", &head, 1);
    std::fs::write(&page, text).expect("a copy of the page");
    let size = format!("--window-size={width},900");
    let output = browser::run(browser, &page, &["--dump-dom", "--virtual-time-budget=600000", &size]);
    let dom = String::from_utf8_lossy(&output.stdout).into_owned();
    let is_result = |line: &&str| ["PASS ", "FAIL ", "DONE "].iter().any(|head| line.starts_with(head));
    dom.lines().filter(is_result).map(str::to_owned).collect()
}

#[track_caller]
pub fn assert_passes(found: &[String], least: usize) {
    assert!(found.iter().any(|line| line.starts_with("DONE")) && found.len() >= least, "{found:#?}");
    assert!(!found.iter().any(|line| line.starts_with("FAIL")), "{found:#?}");
}

/// Window widths of a desktop computer and of a phone, px.
const WIDTHS: [u32; 2] = [1280, 390];

/// Checks the pages in headless Chromium: in light and dark mode, in both window widths, and in print. Without Chromium, the test prints a message
/// and passes, because the project does not require a browser.
#[test]
fn the_page_fits_its_window_and_prints() {
    let Some(browser) = browser::browser() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let measure = |html: &str, width, dark| browser::measure(&browser, folder.path(), html, width, dark);
    for (nth, name) in PAPERS.page_names().iter().enumerate() {
        let html = PAPERS.read(name);
        for (width, dark) in WIDTHS.into_iter().flat_map(|width| [(width, false), (width, true)]) {
            // All pages have the colours of the first page, so dark mode is tested only there.
            if dark && nth > 0 {
                continue;
            }
            let measured = measure(&html, width, dark);
            assert_eq!(measured.window, f64::from(width));
            assert!(measured.page <= measured.window, "{name}, {width} px: {} px: {}", measured.page, measured.wide);
            assert_eq!((measured.drawings, measured.flat), (html.matches("<svg").count(), 0), "{name}, {width} px");
        }
        let (page, pdf) = (folder.path().join("printed.html"), folder.path().join("printed.pdf"));
        std::fs::write(&page, &html).expect("a copy of the page");
        let print = format!("--print-to-pdf={}", pdf.display());
        browser::assert_silent(&browser::run(&browser, &page, &[&print, "--no-pdf-header-footer"]));
        assert!(std::fs::read(&pdf).expect("a PDF").starts_with(b"%PDF"), "{name}");
    }
    // The test detects an element that is too wide.
    let html = PAPERS.read("camera.html");
    let broken = measure(&html.replace("</main>", "<div style=\"width:2000px\">wide</div></main>"), WIDTHS[1], false);
    assert!(broken.page >= 2000.0 && broken.wide.contains("DIV"), "{} px, {}", broken.page, broken.wide);
}

/// After each choice of the reader, the page shows the numbers in the files; choices also work by keyboard and on a phone. A panel whose numbers are
/// missing is hidden.
#[test]
fn choices_change_what_the_page_shows() {
    let Some(browser) = browser::browser() else { return };
    let html = PAPERS.read("maps.html");
    let results = |html: &str| driven(&browser, html, include_str!("explore/after.js"), 1100);
    assert_passes(&results(&html), 20);
    // The test detects a wrong limit.
    let broken = html.replacen("const TRUSTED = 0.1;", "const TRUSTED = 0.2;", 1);
    assert!(results(&broken).iter().any(|line| line.starts_with("FAIL")), "a wrong limit is not seen");
}

/// A page with one animated drawing of three shots.
fn page_with_film() -> String {
    let shot =
        |x: f64| Shot { words: vec![format!("at {x}")], series: vec![Series::nth(0, "", vec![[0.0, 0.0], [x, 1.0]])] };
    let film = Film {
        frame: Frame::half("a film", "three shots"),
        labels: ["x, mm", "y, mm"],
        fixed: Vec::new(),
        shots: [1.0, 2.0, 3.0].map(shot).to_vec(),
        still: 1,
        shot_s: 0.2,
    };
    let figure = Figure::narrow(film.svg().expect("a drawing"), "three shots, one after the other", "film.csv");
    let sections = vec![Section::new("film", "A film", vec![Block::Figure(figure)])];
    let page = Page {
        title: "film".to_owned(),
        first: None,
        push: None,
        explore: None,
        has_film: true,
        sections,
        pages: Vec::new(),
        footer: String::new(),
    };
    page::render(&page).expect("a page")
}

/// An animated drawing runs and can be stopped. The reader can choose a step of the animation, and one shot is shown at a time.
#[test]
fn a_grasp_can_be_stopped_and_stepped() {
    let Some(browser) = browser::browser() else { return };
    let html = page_with_film();
    let results = |html: &str| driven(&browser, html, include_str!("film.js"), 1100);
    assert_passes(&results(&html), 6);
    // The test detects a slider that shows a wrong step.
    let broken = html.replacen("i === step", "i === (step + 1) % 3", 1);
    assert!(results(&broken).iter().any(|line| line.starts_with("FAIL")), "a wrong step is not seen");
}
