//! Sortable tables, and figures with a link to their table.

use maud::{Markup, html};

use super::number;

/// A cell: its content and its sort key.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    shown: Markup,
    /// The number to sort by; `None`: sorted as text.
    value: Option<f64>,
    class: &'static str,
}

impl Cell {
    /// Text.
    pub(super) fn text(text: impl AsRef<str>) -> Cell {
        Cell { shown: html! { (text.as_ref()) }, value: None, class: "" }
    }

    /// Text that may take several lines.
    pub(super) fn prose(text: impl AsRef<str>) -> Cell {
        Cell { class: "prose", ..Cell::text(text) }
    }

    /// Any markup, sorted by its text.
    pub(super) fn markup(shown: Markup) -> Cell {
        Cell { shown, value: None, class: "" }
    }

    /// Any markup that may take several lines.
    pub(super) fn lines(shown: Markup) -> Cell {
        Cell { class: "prose", ..Cell::markup(shown) }
    }

    /// A number with three significant digits.
    pub(super) fn number(value: f64) -> Cell {
        Cell::shown(value, number::figure(value))
    }

    /// A number with its own text.
    pub(super) fn shown(value: f64, shown: impl AsRef<str>) -> Cell {
        Cell { shown: html! { (shown.as_ref()) }, value: Some(value), class: "" }
    }

    /// A number, or a dash.
    pub(super) fn maybe(value: Option<f64>) -> Cell {
        value.map_or_else(Cell::none, Cell::number)
    }

    /// An empty cell, shown as a dash.
    pub(super) fn none() -> Cell {
        Cell { shown: html! { span.dim { "–" } }, value: None, class: "" }
    }

    /// A number with a verdict. A failure is marked by a sign, a frame and bold type, not by colour alone.
    pub(super) fn judged(value: f64, pass: bool) -> Cell {
        let shown = number::figure(value);
        match pass {
            true => Cell::shown(value, shown),
            false => Cell {
                shown: html! { span.sign { "✗ " } (shown) span.unseen { " fails" } },
                value: Some(value),
                class: "bad",
            },
        }
    }

    /// The number of failures; 0 is good.
    pub(super) fn failures(count: usize) -> Cell {
        let value = Some(count as f64);
        match count {
            0 => Cell { value, ..Cell::verdict(true, "0", "") },
            _ => Cell { value, ..Cell::verdict(false, "", &count.to_string()) },
        }
    }

    /// A whole number.
    pub(super) fn count(count: usize) -> Cell {
        Cell::shown(count as f64, count.to_string())
    }

    /// The content, for use outside a table.
    pub(super) fn words(&self) -> Markup {
        html! { span class=(self.class) { (self.shown) } }
    }

    /// A verdict in words.
    pub(super) fn verdict(good: bool, yes: &str, no: &str) -> Cell {
        let (sign, word, class) = if good { ("✓ ", yes, "good") } else { ("✗ ", no, "bad") };
        Cell { shown: html! { span.sign { (sign) } (word) }, value: None, class }
    }
}

/// A column's heading and its meaning.
#[derive(Clone, Debug)]
pub(super) struct Head(pub(super) String, pub(super) &'static str);

/// Headings without a meaning.
pub(super) fn heads<const N: usize>(names: [&str; N]) -> Vec<Head> {
    names.map(|name| Head(name.to_owned(), "")).to_vec()
}

/// An optional anchor and the cells of a row.
pub(super) type Row = (Option<String>, Vec<Cell>);

/// A table in a box, so that a wide table scrolls and the page does not. The first cell of a row is its heading. Columns of
/// numbers are aligned to the right.
pub(super) fn table(id: &str, caption: &str, heads: &[Head], rows: &[Row]) -> Markup {
    let numeric = |column: usize| {
        rows.iter().any(|(_, cells)| cells.get(column).is_some_and(|cell| cell.value.is_some()))
    };
    let numeric: Vec<bool> = (0..heads.len()).map(numeric).collect();
    let class = |column: usize, own: &str| match (numeric.get(column), own) {
        (Some(true), "") => Some("n".to_owned()),
        (Some(true), own) => Some(format!("n {own}")),
        (_, "") => None,
        (_, own) => Some(own.to_owned()),
    };
    html! {
        div.sheet { div.box tabindex="0" role="region" aria-label=(caption) {
            table id=(id) {
                caption { (caption) }
                thead { tr {
                    @for (i, Head(name, hint)) in heads.iter().enumerate() {
                        th scope="col" class=[class(i, "")] title=[(!hint.is_empty()).then_some(hint)] { (name) }
                    }
                } }
                tbody {
                    @for (anchor, cells) in rows {
                        tr id=[anchor.as_ref()] {
                            @for (i, cell) in cells.iter().enumerate() {
                                @if i == 0 {
                                    th scope="row" class=[class(i, cell.class)] data-v=[cell.value] { (cell.shown) }
                                } @else {
                                    td class=[class(i, cell.class)] data-v=[cell.value] { (cell.shown) }
                                }
                            }
                        }
                    }
                }
            }
        } }
    }
}

/// A figure with its caption and a link to its data.
pub(super) fn figure(content: &Markup, caption: &Markup, data: &str) -> Markup {
    html! {
        figure {
            (content)
            figcaption { (caption) " " a.data href={ "#" (data) } { "Data" } }
        }
    }
}
