//! Tests of the page: text is escaped, every block is shown, and nothing is loaded from elsewhere.

use finray_report::page::{Block, Cell, Column, Figure, First, Page, PageLink, Section, Shade, Table, render};

fn page() -> Page {
    let link = |file: &str, heading: &str, is_this| PageLink { file: file.into(), heading: heading.into(), is_this };
    Page {
        title: "Truth <b>".into(),
        first: Some(First {
            headline: ["7 %".into(), "of <all>".into()],
            verdict: vec![["In short?".into(), "So & so.".into()]],
            answers: vec![["Does it?".into(), "It <em>works</em>.".into()]],
            caveat: "all of it simulated".into(),
            lead: vec![figure(Some("lead.csv"))],
            lead_caption: "what the colours say".into(),
            lead_csv: String::new(),
        }),
        push: None,
        explore: None,
        has_film: false,
        sections: vec![section()],
        pages: vec![link("index.html", "Here", true), link("maps.html", "Where & when", false)],
        footer: "the end".into(),
    }
}

fn figure(csv: Option<&str>) -> Figure {
    Figure {
        svg: "<svg viewBox=\"0 0 1 1\"></svg>".into(),
        caption: "force & place".into(),
        csv: csv.map(str::to_owned),
        wide: true,
    }
}

fn section() -> Section {
    let table = Table {
        caption: "Errors".into(),
        columns: [("node", false), ("error, %", true)]
            .map(|(name, numeric)| Column { name: name.into(), numeric })
            .into(),
        rows: vec![
            vec![Cell::file("24.csv"), Cell::shaded("12 < 25", Shade::Amber)],
            vec![Cell::plain("linear finger"), Cell::plain("0")],
        ],
        csv: Some("errors.csv".into()),
    };
    Section {
        id: "maps".into(),
        heading: "Maps".into(),
        says: vec!["It <fails>.".into()],
        blocks: vec![
            Block::Text("a <script> b".into()),
            Block::Figure(figure(Some("map.csv"))),
            Block::Figures(vec![figure(None), figure(None)]),
            Block::Details("More".into(), vec![Block::Table(table), Block::List(vec!["one point".into()])]),
        ],
    }
}

#[test]
fn words_are_escaped_and_drawings_are_not() {
    let html = render(&page()).unwrap();
    assert!(html.contains("a &lt;script&gt; b"));
    assert!(html.contains("It &lt;em&gt;works&lt;&#x2f;em&gt;.") || html.contains("It &lt;em&gt;works&lt;/em&gt;."));
    assert!(html.contains("<title>Truth &lt;b&gt;</title>"));
    assert!(!html.contains("<script") && !html.contains("<em>"));
    assert_eq!(html.matches("<svg viewBox=\"0 0 1 1\"></svg>").count(), 4);
}

#[test]
fn every_block_is_shown_also_within_details() {
    let html = render(&page()).unwrap();
    for part in [
        "<details",
        "<summary>More</summary>",
        "<li>one point</li>",
        "12 &lt; 25",
        "class=\"number amber\"",
        "href=\"errors.csv\"",
        "href=\"map.csv\"",
        "href=\"lead.csv\"",
        "It &lt;fails&gt;.",
        "Does it?",
        "all of it simulated",
        "<strong>7 %</strong> of &lt;all&gt;",
        "So &amp; so.",
        "Where &amp; when",
        "<a href=\"index.html\" aria-current=\"page\">Here</a>",
        "href=\"maps.html\"",
        "<a href=\"24.csv\">24.csv</a>",
        "<abbr title=\"The finger with linear statics\">linear finger</abbr>",
        "id=\"maps\"",
        "the end",
    ] {
        assert!(html.contains(part), "{part}");
    }
}

#[test]
fn the_page_needs_nothing_but_itself() {
    let html = render(&page()).unwrap();
    for outside in ["http://", "https://", "src=", "@import", "url("] {
        assert!(!html.contains(outside), "{outside}");
    }
    assert!(html.contains("<html lang=\"en\">") && html.contains("name=\"viewport\""));
}
