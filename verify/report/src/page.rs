//! The report's pages, each a self-contained HTML file.
//!
//! A page is plain data, rendered through one template. SVG is inserted unchanged; other text is escaped.

use finray_model::estimators::EstimatorId;
use finray_studies::truths::TruthId;
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, context};
use serde::Serialize;
use std::collections::BTreeMap;

/// Script of the interactive section.
pub const SCRIPT: &str = include_str!("explore/explore.js");
/// Style sheet of the interactive section.
pub const STYLE: &str = include_str!("explore/explore.css");

/// Script and style sheet of the finger that the reader can push, and script of the page on which the reader edits the scene of this finger.
const PUSH: [&str; 3] = [include_str!("push/push.js"), include_str!("push/push.css"), include_str!("push/own.js")];

/// Content of one page.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Page {
    /// Title of the page.
    pub title: String,
    /// First screen of the report; `None` on all pages but the first.
    pub first: Option<First>,
    /// The finger that the reader can push; `None` on a page without this finger.
    pub push: Option<Pushable>,
    /// Data of the interactive section; `None` on a page without this section.
    pub explore: Option<String>,
    /// Whether a drawing is animated, so that the page needs the script that stops animations.
    pub has_film: bool,
    /// The results, in the order of the page.
    pub sections: Vec<Section>,
    /// All pages of the report, including this page.
    pub pages: Vec<PageLink>,
    /// Text in small print at the end of the page.
    pub footer: String,
}

/// First screen of the report: verdict, answers and drawings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct First {
    /// The trusted share, in large type, and what it means.
    pub headline: [String; 2],
    /// Short verdict, beside the picture: questions in the reader's words, each with its answer.
    pub verdict: Vec<[String; 2]>,
    /// The reader's questions with their full answers.
    pub answers: Vec<[String; 2]>,
    /// Assumptions behind the answers.
    pub caveat: String,
    /// Drawings of the trusted cells.
    pub lead: Vec<Figure>,
    /// Text below the drawings of `lead`.
    pub lead_caption: String,
    /// Path, relative to the page, of the file with the cells of these drawings.
    pub lead_csv: String,
}

/// A finger that the reader can push: its program and its data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pushable {
    /// WebAssembly, compressed by gzip, in base64.
    pub program: String,
    /// Scene and map as JSON.
    pub data: String,
    /// Whether the reader can change the scene.
    pub is_edited: bool,
    /// Whether the program was built from the code that computed the report.
    pub is_current: bool,
}

/// Link to a page of the report, for the navigation of another page.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PageLink {
    /// File name of the linked page, which is in the same folder as the linking page.
    pub file: String,
    /// Heading of the linked page in the navigation.
    pub heading: String,
    /// Whether the linked page is the page that shows the link.
    pub is_this: bool,
}

/// A part of the page with its own heading.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Section {
    /// Anchor for links within the page.
    pub id: String,
    /// Heading, also shown in the table of contents.
    pub heading: String,
    /// Conclusions from the section's numbers, shown first.
    pub says: Vec<String>,
    /// Content of the section, in order.
    pub blocks: Vec<Block>,
}

/// One element of a section.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", content = "of", rename_all = "snake_case")]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// A bulleted list.
    List(Vec<String>),
    /// A single figure.
    Figure(Figure),
    /// Figures side by side, or one below the other on a narrow screen.
    Figures(Vec<Figure>),
    /// A table.
    Table(Table),
    /// A summary line, and blocks that are hidden until the reader opens the line; in print they are visible.
    Details(String, Vec<Block>),
}

/// A drawing with a caption.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// SVG of the drawing. The SVG is inserted unescaped, so it must not contain foreign text.
    pub svg: String,
    /// Text below the drawing.
    pub caption: String,
    /// Path, relative to the page, of the file with the drawn numbers.
    pub csv: Option<String>,
    /// Whether the drawing scrolls sideways on a narrow screen instead of shrinking.
    pub wide: bool,
}

impl Figure {
    /// A drawing as wide as the page's column.
    pub fn wide(svg: String, caption: impl Into<String>, csv: impl Into<String>) -> Figure {
        Figure { svg, caption: caption.into(), csv: Some(csv.into()), wide: true }
    }

    /// A drawing that is narrow enough for half a row of the page, or for a phone.
    pub fn narrow(svg: String, caption: impl Into<String>, csv: impl Into<String>) -> Figure {
        Figure { wide: false, ..Figure::wide(svg, caption, csv) }
    }
}

/// Numbers in rows and columns.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Table {
    /// Text above the table.
    pub caption: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows, with one cell per column.
    pub rows: Vec<Vec<Cell>>,
    /// Path, relative to the page, of the file with the same numbers.
    pub csv: Option<String>,
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Column {
    /// Heading of the column.
    pub name: String,
    /// Whether cells are right-aligned, as numbers are.
    pub numeric: bool,
}

/// A cell of a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// Text of the cell.
    pub text: String,
    /// Background of the cell.
    pub shade: Option<Shade>,
    /// Path, relative to the page, of the file to which the text links.
    pub link: Option<String>,
}

/// Meaning of a cell's background.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shade {
    /// Green: passed.
    Pass,
    /// Red: failed.
    Fail,
    /// Amber: an error above 10 %.
    Amber,
    /// Red: an error above 25 %.
    Red,
}

/// A paragraph.
pub fn text(paragraph: impl Into<String>) -> Block {
    Block::Text(paragraph.into())
}

/// Blocks that are hidden until the reader opens their summary line.
pub fn details(summary: impl Into<String>, blocks: Vec<Block>) -> Block {
    Block::Details(summary.into(), blocks)
}

impl Section {
    /// A section with anchor, heading and blocks, without conclusions.
    pub fn new(id: &str, heading: &str, blocks: Vec<Block>) -> Self {
        Self { id: id.to_owned(), heading: heading.to_owned(), says: Vec::new(), blocks }
    }

    /// Adds conclusions to the section.
    pub fn saying(self, says: impl IntoIterator<Item = String>) -> Self {
        Self { says: says.into_iter().collect(), ..self }
    }
}

impl Cell {
    /// A cell without background.
    pub fn plain(text: impl Into<String>) -> Self {
        Self { text: text.into(), shade: None, link: None }
    }

    /// A cell with a background.
    pub fn shaded(text: impl Into<String>, shade: Shade) -> Self {
        Self { shade: Some(shade), ..Self::plain(text) }
    }

    /// A cell that names and links to a file beside the page.
    pub fn file(name: impl Into<String>) -> Self {
        let name = name.into();
        Self { link: Some(name.clone()), ..Self::plain(name) }
    }
}

/// Explanations of the names of true fingers and estimators, shown when the pointer rests on a name.
pub(super) fn about() -> BTreeMap<&'static str, &'static str> {
    let fingers = TruthId::ALL.iter().map(|truth| (truth.label(), truth.help()));
    fingers.chain(EstimatorId::ALL.iter().map(|estimator| (estimator.label(), estimator.help()))).collect()
}

/// Renders the page as HTML.
pub fn render(page: &Page) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    // With these settings, lines that have only template instructions leave no empty line.
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?;
    environment.set_syntax(syntax);
    environment.add_template("page.html", include_str!("page.html"))?;
    let [page_script, film] = [include_str!("page.js"), include_str!("film.js")];
    let scripts = context! { page => page_script, explore => SCRIPT, push => PUSH[0], own => PUSH[2], film };
    let styles = context! { page => include_str!("page.css"), explore => STYLE, push => PUSH[1] };
    let page = context! { page => Serde(page), about => about(), scripts, styles };
    environment.get_template("page.html")?.render(page)
}
