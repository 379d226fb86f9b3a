//! An artificial report, read back from each of its formats.

use crate::sample::{HOSTILE, colours, drives, report};
use roxmltree::{Document, Node, ParsingOptions};
use std::collections::HashSet;
use stiction_draw::figure::{Figure, Line, Panel};
use stiction_zhang2018::report::{Block, Cell, Finding, Report, Section, Table};

fn parse(text: &str) -> Document<'_> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Concatenated text of a node.
fn text(node: Node<'_, '_>) -> String {
    let texts =
        node.descendants().filter(Node::is_text).filter_map(|n| n.text().map(str::to_owned));
    texts.collect()
}

fn elements<'a>(within: Node<'a, 'a>, name: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    within.descendants().filter(move |node| node.tag_name().name() == name)
}

/// Removes characters that XML does not allow.
fn kept(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).collect()
}

fn blocks(report: &Report) -> impl Iterator<Item = &Block> {
    report.sections.iter().flat_map(|section| &section.blocks)
}

fn tables(report: &Report) -> impl Iterator<Item = &Table> {
    blocks(report).filter_map(|block| match block {
        Block::Table(table) => Some(table),
        _ => None,
    })
}

/// Creates a report with these blocks.
fn of(blocks: Vec<Block>) -> Report {
    let section = Section { id: "one".into(), title: "One".into(), blocks };
    Report { title: "Made up".into(), lead: vec![], sections: vec![section], footer: vec![] }
}

#[test]
fn a_page_needs_nothing_else() {
    let html = report().html();
    let page = parse(&html);
    let foreign = ["script", "link", "img", "iframe", "image", "use", "object", "embed", "base"];
    assert!(page.descendants().all(|node| !foreign.contains(&node.tag_name().name())));
    let mut names = HashSet::new();
    for node in page.descendants() {
        if let Some(id) = node.attribute("id") {
            assert!(names.insert(id), "{id} is there twice");
        }
    }
    let mut links = 0;
    for node in page.descendants() {
        for attribute in node.attributes() {
            let (name, value) = (attribute.name(), attribute.value());
            assert!(!["src", "srcset", "action", "data", "style"].contains(&name), "{name}");
            assert!(!name.starts_with("on"), "{name}");
            if name == "href" {
                let target = value.strip_prefix('#').unwrap_or_else(|| panic!("{value}"));
                assert!(names.contains(target), "{target}");
                links += 1;
            }
            if let Some((_, rest)) = value.split_once("url(") {
                let target = rest.strip_prefix('#').and_then(|rest| rest.split_once(')')).unwrap();
                assert!(names.contains(target.0), "{value}");
            }
        }
    }
    // Twice the contents and the numbers of headings; the three of the prose are there five times.
    assert!(links >= 3 * 6 + 3 * 5, "{links}");
    for style in elements(page.root(), "style").map(text) {
        assert!(!style.contains("url(") && !style.contains("@import"), "{style}");
    }
}

#[test]
fn a_page_contains_all_results() {
    let report = report();
    let html = report.html();
    let page = parse(&html);
    let whole = text(page.root());
    // A section's title, which occurs in both tables of contents, and an equation's number.
    let number = kept(HOSTILE).replace('-', "–");
    assert_eq!(whole.matches(&kept(HOSTILE)).count(), 3, "{whole}");
    assert_eq!(whole.matches(&number).count(), 1, "{whole}");
    // Markup is interpreted everywhere else: in a formula, three captions and ten cells, a
    // paragraph, a finding, a list item, and the footer.
    let read = kept(HOSTILE).replace("`x`", "x").replace("\\*", "*");
    let read = read.replace("&nbsp;", "\u{a0}").replace("_u_", "u");
    assert_eq!(whole.matches(&read).count(), 1 + 3 + 10 + 1 + 1 + 1 + 1, "{whole}");
    let headings: Vec<String> = elements(page.root(), "h2").map(text).collect();
    let titles = report.sections.iter().enumerate();
    let titles: Vec<String> =
        titles.map(|(k, s)| format!("{} {}", k + 1, kept(&s.title))).collect();
    assert_eq!(headings, titles);
    for word in ["Right", "Wrong", "Open", "Note"] {
        let of_class = |node: &Node<'_, '_>| node.attribute("class") == Some("verdict");
        assert!(page.descendants().any(|n| of_class(&n) && text(n) == word), "{word}");
    }
    for number in ["(1)", "(12a)"] {
        let equation = page.descendants().filter(|n| n.attribute("class") == Some("equation"));
        assert!(equation.map(text).any(|text| text.ends_with(number)), "{number}");
    }
    assert!(page.descendants().any(|n| n.attribute("id") == Some("eq-12a")));
    assert!(!whole.contains("NaN") && whole.contains("https://example.org/a"));
}

/// Plots in the page use the page's colours.
#[test]
fn plots_follow_the_page() {
    let html = report().html();
    let page = parse(&html);
    let plots: Vec<_> =
        elements(page.root(), "svg").filter(|n| n.attribute("class") == Some("curves")).collect();
    assert_eq!(plots.len(), 2);
    for plot in &plots {
        for node in plot.descendants() {
            for name in ["fill", "stroke"] {
                let Some(paint) = node.attribute(name) else { continue };
                assert!(paint == "none" || paint.starts_with("var(--"), "{name} {paint}");
            }
        }
        let frame =
            plot.attribute("viewBox").unwrap().split(' ').map(|x| x.parse::<f64>().unwrap());
        assert!(frame.skip(2).all(|side| side > 100.0));
        assert!(plot.attribute("width").is_none() && plot.attribute("height").is_none());
    }
    assert!(elements(plots[0], "text").any(|node| text(node).starts_with('−')));
    let strokes = |plot: Node<'_, '_>| -> Vec<String> {
        elements(plot, "path").filter_map(|n| n.attribute("stroke").map(str::to_owned)).collect()
    };
    assert_eq!(strokes(plots[0]).len(), 12);
    let drawn: HashSet<String> = strokes(plots[1]).into_iter().collect();
    assert_eq!(drawn.len(), 8, "{drawn:?}");
    for k in 0..8 {
        assert!(drawn.contains(&format!("var(--line{k})")));
        // One definition for light colours, one for dark colours.
        assert_eq!(html.matches(&format!("--line{k}:#")).count(), 2);
    }
}

/// Legend entries of a figure in a report.
fn legends(figure: Figure) -> Vec<Vec<String>> {
    let report = of(vec![Block::Curves { id: "f".into(), figure, caption: String::new() }]);
    let html = report.html();
    let page = parse(&html);
    let lists = elements(page.root(), "ul").filter(|n| n.attribute("class") == Some("legend"));
    lists.map(|list| elements(list, "li").map(text).collect()).collect()
}

#[test]
fn legends_are_common_where_lines_mean_the_same() {
    assert_eq!(legends(drives()).len(), 1);
    assert_eq!(legends(drives())[0].len(), 6);
    assert_eq!(legends(colours())[0].len(), 11);
    let mut figure = drives();
    figure.panels[1].lines[0].label = "something else".into();
    // Without a legend, the names are at the ends of the lines.
    let markup = figure.inline("");
    assert!(markup.contains(">something else</text>"));
    assert!(legends(figure).is_empty());
}

/// Tests if `shown` is the cell's number, rounded to the digits that the cell requests.
fn is_shown(cell: &Cell, shown: &str) -> bool {
    let (x, unit) = match *cell {
        Cell::Text(_) => return true,
        Cell::Empty => return shown.is_empty(),
        Cell::Number(x, _) | Cell::Fixed(x, _) if x.is_nan() => return shown == "none",
        Cell::Number(x, _) | Cell::Fixed(x, _) if x.is_infinite() => {
            return shown == if x > 0.0 { "∞" } else { "-∞" };
        }
        Cell::Number(x, digits) if x != 0.0 => {
            (x, 10f64.powi(x.abs().log10().floor() as i32 + 1 - digits as i32))
        }
        // A number that is too large for digits after the point is shown with four significant
        // digits.
        Cell::Fixed(x, _) if x.abs() >= 1e15 => (x, 1e-3 * x.abs()),
        Cell::Number(x, digits) | Cell::Fixed(x, digits) => (x, 10f64.powi(-(digits as i32))),
    };
    // Half a unit of the last digit, and rounding when a decimal number is read.
    shown.parse::<f64>().is_ok_and(|read| (read - x).abs() <= 0.5 * unit + 1e-15 * x.abs())
}

#[test]
fn a_page_has_every_number() {
    let report = report();
    let html = report.html();
    let page = parse(&html);
    let shown: Vec<_> = elements(page.root(), "table").collect();
    assert_eq!(shown.len(), tables(&report).count());
    for (table, shown) in tables(&report).zip(shown) {
        let rows: Vec<_> = elements(elements(shown, "tbody").next().unwrap(), "tr").collect();
        assert_eq!(rows.len(), table.rows.len());
        for (row, shown) in table.rows.iter().zip(rows) {
            let cells: Vec<_> = elements(shown, "td").collect();
            assert_eq!(cells.len(), row.len());
            for (cell, shown) in row.iter().zip(cells) {
                let read = text(shown).replace('−', "-").replace("\u{202f}×\u{202f}10", "e");
                assert!(is_shown(cell, &read), "{cell:?}: {read}");
                if matches!(cell, Cell::Number(..) | Cell::Fixed(..)) {
                    assert_eq!(shown.attribute("class"), Some("number"), "{cell:?}");
                }
            }
        }
        let heads: Vec<String> = elements(shown, "th").map(text).collect();
        for (column, head) in table.columns.iter().zip(heads) {
            assert!(head.ends_with(&match column.unit.as_str() {
                "" => String::new(),
                unit => format!(" [{unit}]"),
            }));
        }
    }
}

/// Cells of a Markdown table row; an escaped pipe does not end a cell.
fn cells(row: &str) -> Vec<String> {
    let row = row.strip_prefix("| ").and_then(|row| row.strip_suffix('|')).unwrap();
    let mut cells = vec![String::new()];
    let mut signs = row.chars();
    while let Some(sign) = signs.next() {
        let last = cells.last_mut().unwrap();
        match sign {
            '\\' => last.extend(signs.next()),
            '|' => cells.push(String::new()),
            sign => last.push(sign),
        }
    }
    cells.iter().map(|cell| cell.trim().to_owned()).collect()
}

#[test]
fn markdown_has_every_number() {
    let report = report();
    let markdown = report.markdown();
    let mut rows = markdown.lines().filter(|line| line.starts_with('|'));
    for table in tables(&report).filter(|table| !table.columns.is_empty()) {
        assert_eq!(cells(rows.next().unwrap()).len(), table.columns.len());
        let rule = cells(rows.next().unwrap());
        assert!(rule.len() == table.columns.len() && rule.iter().all(|cell| cell.contains("---")));
        for row in &table.rows {
            let shown = cells(rows.next().unwrap());
            assert_eq!(shown.len(), row.len(), "{shown:?}");
            for (cell, shown) in row.iter().zip(&shown) {
                assert!(is_shown(cell, shown), "{cell:?}: {shown}");
            }
        }
    }
    assert_eq!(rows.next(), None);
    assert!(!markdown.contains("NaN"));
}

#[test]
fn markdown_shows_the_files() {
    let report = report();
    let markdown = report.markdown();
    let files: Vec<String> = report.pictures().into_iter().map(|(name, _)| name).collect();
    assert_eq!(files, ["drives.svg", "colours.svg", "picture-1.svg", "picture-2.svg"]);
    let images = markdown.lines().filter(|line| line.starts_with("!["));
    let shown: Vec<&str> =
        images.map(|line| line.rsplit_once("](").unwrap().1.strip_suffix(')').unwrap()).collect();
    assert_eq!(shown, files);
}

#[test]
fn links_of_markdown_have_their_targets() {
    let markdown = report().markdown();
    let between = |open: &str, close: &str| -> Vec<String> {
        let pieces = markdown.split(open).skip(1).map(|rest| rest.split_once(close).unwrap().0);
        pieces.map(str::to_owned).collect()
    };
    let places = between("<a id=\"", "\"></a>");
    let names: HashSet<&String> = places.iter().collect();
    assert_eq!(names.len(), places.len(), "{places:?}");
    let links = between("](#", ")");
    // Three links in each of the five copies of the prose.
    assert!(links.len() >= 3 * 5, "{links:?}");
    for link in &links {
        assert!(names.contains(link), "{link}");
    }
}

/// Markdown contains the intended elements and none from the content.
#[test]
fn markdown_is_not_broken_out_of() {
    let markdown = report().markdown();
    for foreign in ["<script", "</p", "<!--", "[x](", "\u{0}", "\u{7}"] {
        assert!(!markdown.contains(foreign), "{foreign}");
    }
    for (k, _) in markdown.match_indices('<') {
        let name: String = markdown[k + 1..]
            .chars()
            .take_while(|c| c.is_ascii_alphabetic() || *c == '/')
            .collect();
        let meant = ["strong", "em", "sub", "sup", "code", "a"];
        assert!(meant.contains(&name.trim_start_matches('/')), "{name}");
    }
    let own: Vec<&str> = markdown.lines().filter(|line| line.starts_with('#')).collect();
    assert_eq!(own.len(), 1 + 6, "{own:?}");
    for mine in
        ["\\- none either", "1\\. no list", "**Wrong:** ", "<a id=\"drives\"></a>", "(#drives)"]
    {
        assert!(markdown.contains(mine), "{mine}");
    }
}

fn read(csv: &str) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(csv.as_bytes());
    reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect()
}

/// Number in a cell of a file; an empty cell is NaN.
fn value(cell: &str) -> f64 {
    if cell.is_empty() { f64::NAN } else { cell.parse().unwrap() }
}

fn file(report: &Report, name: &str) -> Vec<Vec<String>> {
    read(&report.tables().iter().find(|(own, _)| own == name).unwrap().1)
}

#[test]
fn files_of_tables_have_the_same_numbers() {
    let report = report();
    for table in tables(&report).filter(|table| !table.columns.is_empty()) {
        let rows = file(&report, &format!("{}.csv", table.id));
        assert_eq!(rows.len(), 1 + table.rows.len());
        for (row, read) in table.rows.iter().zip(&rows[1..]) {
            assert_eq!(row.len(), read.len());
            for (cell, read) in row.iter().zip(read) {
                match cell {
                    Cell::Number(x, _) | Cell::Fixed(x, _) if x.is_nan() => assert_eq!(read, ""),
                    Cell::Number(x, _) | Cell::Fixed(x, _) => assert_eq!(value(read), *x),
                    Cell::Empty => assert_eq!(read, ""),
                    Cell::Text(_) => {}
                }
            }
        }
    }
    let odd = file(&report, "odd.csv");
    assert_eq!(odd[0], ["name|pipe [m/s²]", "number, comma [N]", "fixed", "only words"]);
    assert_eq!(odd[1][0], "case 0 \"quoted\", and more");
    assert_eq!(file(&report, "wide.csv")[1][9].matches('*').count(), 0);
}

#[test]
fn files_of_curves_have_every_point() {
    let report = report();
    for (name, figure) in [("drives.csv", drives()), ("colours.csv", colours())] {
        let rows = file(&report, name);
        let column = |head: &str| -> Vec<f64> {
            let k = rows[0].iter().position(|own| own == head).unwrap_or_else(|| panic!("{head}"));
            rows[1..].iter().map(|row| value(&row[k])).collect()
        };
        let heads: HashSet<&String> = rows[0].iter().collect();
        assert_eq!(heads.len(), rows[0].len(), "every column has its own name");
        for panel in &figure.panels {
            for line in &panel.lines {
                let head = match panel.y_label.split_once(" [") {
                    Some((name, unit)) => format!("{name}: {} [{unit}", line.label),
                    None => line.label.clone(),
                };
                let values = column(&head);
                for (k, point) in line.points.iter().enumerate() {
                    assert!(
                        values[k] == point.1 || (values[k].is_nan() && point.1.is_nan()),
                        "{head}"
                    );
                }
                assert!(values[line.points.len()..].iter().all(|x| x.is_nan()));
            }
        }
    }
    // Twelve lines share their abscissae; three others have abscissae of their own.
    assert_eq!(file(&report, "drives.csv")[0].len(), 1 + 12);
    assert_eq!(file(&report, "colours.csv")[0].len(), (1 + 8) + 3 * 2);
    let times: Vec<f64> =
        file(&report, "drives.csv")[1..].iter().map(|row| value(&row[0])).collect();
    let expected: Vec<f64> = drives().panels[0].lines[0].points.iter().map(|p| p.0).collect();
    assert_eq!(times, expected);
    let heads = file(&report, "colours.csv").remove(0);
    assert!(heads.contains(&"time (2) [s]".to_owned()), "{heads:?}");
}

#[test]
fn lines_of_one_name_have_their_own_columns() {
    let line = |value: f64| Line {
        label: "a".into(),
        points: vec![(0.0, value)],
        colour: 0,
        dashed: false,
    };
    let panels = vec![Panel {
        y_label: "force [N]".into(),
        lines: vec![line(1.0), line(2.0)],
        ..Panel::default()
    }];
    let figure = Figure { title: String::new(), x_label: "time [s]".into(), panels };
    let report = of(vec![Block::Curves { id: "f".into(), figure, caption: String::new() }]);
    let expected = [vec!["time [s]", "a [N]", "a (2) [N]"], vec!["0", "1", "2"]];
    assert_eq!(file(&report, "f.csv"), expected);
}

/// Picture files have a white background and define all colours that they use.
#[test]
fn pictures_stand_alone() {
    for (name, svg) in report().pictures() {
        let picture = parse(&svg);
        assert_eq!(
            picture.root_element().tag_name().namespace(),
            Some("http://www.w3.org/2000/svg")
        );
        if svg.contains("var(--ink)") {
            assert!(svg.contains("--ink:#"), "{name}");
        }
    }
    let svg = "<svg viewBox=\"0 0 1 1\"><style>@media screen and (prefers-color-scheme:dark){a{}}\
               @media (prefers-color-scheme:dark){b{}}</style></svg>";
    let report = of(vec![Block::Picture { svg: svg.into(), caption: String::new() }]);
    let svg = &report.pictures()[0].1;
    parse(svg);
    assert!(
        svg.contains("xmlns=\"http://www.w3.org/2000/svg\"") && svg.contains("background:#fff")
    );
    assert!(
        !svg.contains("prefers") && svg.contains("@media not all{a{}}@media not all{b{}}"),
        "{svg}"
    );
}

#[test]
fn defects_are_found() {
    let made_up = report().defects();
    // The equation with an unusual number.
    assert_eq!(made_up.len(), 1, "{made_up:?}");
    assert!(made_up[0].contains("is no name"));

    let mut short = Table::new("t", "", [("a", ""), ("b", "")]);
    short.rows.push(vec!["x".into()]);
    let figure = Figure { title: String::new(), x_label: String::new(), panels: vec![] };
    let mut report = of(vec![
        Block::Paragraph("[a](#one) [b](#two)".into()),
        Block::Finding(Finding::Note, "[c](#table-t) [d](#eq-3)".into()),
        Block::Table(short),
        Block::Table(Table::new("t", "[e](#nowhere)", [("a", "")])),
        Block::Curves { id: "t".into(), figure, caption: String::new() },
        Block::Equation { number: "3".into(), formula: "a".into() },
    ]);
    report.sections.push(Section { id: "one".into(), title: String::new(), blocks: vec![] });
    let expected = [
        "`one` is there twice",
        "`table-t` is there twice",
        "two files are named `t.csv`",
        "two files are named `t.csv`",
        "a link leads to `#two`, which does not exist",
        "a link leads to `#nowhere`, which does not exist",
        "row 1 of `t` has 1 cells for 2 columns",
    ];
    assert_eq!(report.defects(), expected);
    // Even in this case, no name occurs twice in the page.
    let html = report.html();
    let page = parse(&html);
    assert_eq!(page.descendants().filter(|n| n.attribute("id") == Some("one")).count(), 1);
}

/// Rows shorter or longer than the header are rendered.
#[test]
fn rows_of_any_length_are_drawn() {
    let mut table = Table::new("t", "", [("a", ""), ("b", "")]);
    table.rows.push(vec![]);
    table.rows.push(vec!["x".into(), Cell::Number(1.0, 3), Cell::Number(2.0, 3)]);
    let report = of(vec![Block::Table(table)]);
    parse(&report.html());
    let rows = file(&report, "t.csv");
    assert_eq!(rows, [vec!["a", "b"], vec!["", ""], vec!["x", "1"]]);
    let markdown = report.markdown();
    assert!(markdown.lines().filter(|line| line.starts_with('|')).all(|row| cells(row).len() == 2));
}
