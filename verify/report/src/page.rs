//! The report as one HTML page that needs nothing but itself.
//!
//! A page is plain data, rendered through one template; SVG goes in as it is, other text escaped.

use finray_model::estimators::EstimatorId;
use finray_studies::truths::TruthId;
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, context};
use serde::Serialize;
use std::collections::BTreeMap;

/// Script of the section in which the reader chooses what is drawn.
pub const SCRIPT: &str = include_str!("explore/explore.js");
/// Its style.
pub const STYLE: &str = include_str!("explore/explore.css");

/// A whole page.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Page {
    /// Name of the page.
    pub title: String,
    /// One sentence under the title.
    pub subtitle: String,
    /// The reader's questions with their answers; shown before everything else.
    pub answers: Vec<Answer>,
    /// What the answers rest on.
    pub caveat: String,
    /// The drawings beside and below the answers.
    pub lead: Vec<Figure>,
    /// Words below these drawings.
    pub lead_caption: String,
    /// Numbers for the script that answers the reader's choices; `None`: no such section.
    pub explore: Option<String>,
    /// The results, question by question, in the order of the table of contents.
    pub questions: Vec<Question>,
    /// Small print at the end.
    pub footer: String,
}

/// A question, answered in few sentences.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// The question.
    pub question: String,
    /// The answer.
    pub answer: String,
}

/// A question of the reader, and the sections that answer it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Question {
    /// Anchor for links within the page.
    pub id: String,
    /// The question, in few words.
    pub heading: String,
    /// The sections, in order.
    pub sections: Vec<Section>,
}

/// A part of the page under its own heading.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Section {
    /// Anchor for links within the page.
    pub id: String,
    /// Heading, also shown in the table of contents.
    pub heading: String,
    /// What the section's numbers say, in sentences; shown before the rest.
    pub says: Vec<String>,
    /// What the section is made of, in order.
    pub blocks: Vec<Block>,
}

/// One thing in a section.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Block {
    /// A paragraph.
    Text {
        /// Its words.
        paragraph: String,
    },
    /// Several points, one below the other.
    List {
        /// The points' words.
        items: Vec<String>,
    },
    /// A figure on its own.
    Figure(Figure),
    /// Figures side by side, one below the other where the screen is narrow.
    Figures {
        /// The figures.
        figures: Vec<Figure>,
    },
    /// A table.
    Table(Table),
    /// Blocks that are shown when asked for (and in print).
    Details {
        /// The line that is always shown.
        summary: String,
        /// What it hides.
        blocks: Vec<Block>,
    },
}

/// A drawing with words below it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// The drawing; put into the page as it is, so it must come from our own code.
    pub svg: String,
    /// Words below the drawing.
    pub caption: String,
    /// Where the drawn numbers lie, seen from the page.
    pub csv: Option<String>,
    /// A wide drawing is scrolled sideways on a narrow screen rather than shrunk beyond reading.
    pub wide: bool,
}

impl Figure {
    /// A drawing that is as wide as the page's column.
    pub fn wide(svg: String, caption: impl Into<String>, csv: impl Into<String>) -> Figure {
        Figure { svg, caption: caption.into(), csv: Some(csv.into()), wide: true }
    }

    /// A drawing that shares its row with another, or is read on a phone.
    pub fn narrow(svg: String, caption: impl Into<String>, csv: impl Into<String>) -> Figure {
        Figure { wide: false, ..Figure::wide(svg, caption, csv) }
    }
}

/// Numbers in rows and columns.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Table {
    /// Words above the table.
    pub caption: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows, each with one cell a column.
    pub rows: Vec<Vec<Cell>>,
    /// Where the same numbers lie as a file, seen from the page.
    pub csv: Option<String>,
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Column {
    /// Its heading.
    pub name: String,
    /// Numbers are set flush right, words flush left.
    pub numeric: bool,
}

/// A cell of a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// What stands in it.
    pub text: String,
    /// Its background.
    pub shade: Option<Shade>,
    /// A file that its text leads to, seen from the page.
    pub link: Option<String>,
}

/// What a cell's background says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shade {
    /// Green: as it should be.
    Pass,
    /// Red: not as it should be.
    Fail,
    /// Amber: an error of more than a tenth.
    Amber,
    /// Red: an error of more than a quarter.
    Red,
}

/// A paragraph.
pub fn text(paragraph: impl Into<String>) -> Block {
    Block::Text { paragraph: paragraph.into() }
}

/// Blocks under a line that opens them.
pub fn details(summary: impl Into<String>, blocks: Vec<Block>) -> Block {
    Block::Details { summary: summary.into(), blocks }
}

impl Section {
    /// A section by its anchor, heading and blocks; its numbers say nothing yet.
    pub fn new(id: &str, heading: &str, blocks: Vec<Block>) -> Self {
        Self { id: id.to_owned(), heading: heading.to_owned(), says: Vec::new(), blocks }
    }

    /// The section with the sentences that its numbers say.
    pub fn saying(self, says: impl IntoIterator<Item = String>) -> Self {
        Self { says: says.into_iter().collect(), ..self }
    }
}

impl Column {
    /// A column of words.
    pub fn words(name: impl Into<String>) -> Self {
        Self { name: name.into(), numeric: false }
    }

    /// A column of numbers.
    pub fn numbers(name: impl Into<String>) -> Self {
        Self { name: name.into(), numeric: true }
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

    /// The name of a file beside the page, which it leads to.
    pub fn file(name: impl Into<String>) -> Self {
        let name = name.into();
        Self { link: Some(name.clone()), ..Self::plain(name) }
    }
}

/// What is meant by the names of true fingers and estimators, told where a pointer rests on one.
pub(super) fn about() -> BTreeMap<&'static str, &'static str> {
    let fingers = TruthId::ALL.iter().map(|truth| (truth.label(), truth.help()));
    fingers.chain(EstimatorId::ALL.iter().map(|estimator| (estimator.label(), estimator.help()))).collect()
}

/// The page as HTML.
pub fn render(page: &Page) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    // Lines that hold only a template's instructions leave no empty line behind.
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?;
    environment.set_syntax(syntax);
    environment.add_template("page.html", include_str!("page.html"))?;
    let page = context! { page => Serde(page), about => about(), script => SCRIPT, style => STYLE };
    environment.get_template("page.html")?.render(page)
}
