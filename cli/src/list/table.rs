//! Plain text tables.

/// A table whose columns are as wide as their widest cell. Numbers are aligned to the right. Every row must have as many
/// cells as the heading.
pub fn text(head: &[&str], rows: Vec<Vec<String>>) -> String {
    let head: Vec<String> = head.iter().map(ToString::to_string).collect();
    let columns = head.len();
    let rows: Vec<Vec<String>> = std::iter::once(head).chain(rows).collect();
    let cells = |column: usize| rows.iter().filter_map(move |row| row.get(column));
    let widths: Vec<usize> = (0..columns)
        .map(|column| cells(column).map(|cell| cell.chars().count()).max().unwrap_or(0))
        .collect();
    let is_number = |column: usize| {
        rows.len() > 1 && cells(column).skip(1).all(|cell| cell.parse::<f64>().is_ok())
    };
    let right: Vec<bool> = (0..columns).map(is_number).collect();
    let mut text = String::new();
    for row in &rows {
        let padded = row.iter().zip(&widths).zip(&right).map(|((cell, width), right)| {
            // the padding of `format!` ends at 65535 columns
            let space = " ".repeat(width - cell.chars().count());
            if *right { space + cell } else { cell.clone() + &space }
        });
        text += padded.collect::<Vec<_>>().join("  ").trim_end();
        text.push('\n');
    }
    text
}

/// Maximum width of a list, in columns.
const WIDTH: usize = 100;

/// A heading with items after it, on as many lines as needed. Lines after the first are indented.
pub(crate) fn wrapped(head: &str, items: &[String], between: &str) -> String {
    const INDENT: &str = "      ";
    let mut text = String::new();
    let mut line = head.to_owned();
    for (i, item) in items.iter().enumerate() {
        let item = if i + 1 < items.len() {
            format!("{item}{}", between.trim_end())
        } else {
            item.clone()
        };
        if line.chars().count() + 1 + item.chars().count() > WIDTH {
            text += &line;
            text.push('\n');
            line = format!("{INDENT}{item}");
        } else {
            line = format!("{line} {item}");
        }
    }
    text + &line + "\n"
}

#[cfg(test)]
mod tests {
    #[test]
    fn long_lists_break_between_items() {
        let items: Vec<String> = (0..40).map(|i| format!("item {i}")).collect();
        let text = super::wrapped("head:", &items, ", ");
        assert!(text.lines().all(|line| line.chars().count() <= super::WIDTH));
        let whole = text.lines().map(str::trim).collect::<Vec<_>>().join(" ");
        assert_eq!(whole, format!("head: {}", items.join(", ")));
        assert_eq!(super::wrapped("head:", &[], ", "), "head:\n");
    }

    #[test]
    fn numbers_stand_right_and_words_left() {
        let rows =
            vec![vec!["µm".to_owned(), "7".to_owned()], vec!["long".to_owned(), "12".to_owned()]];
        assert_eq!(super::text(&["a", "b"], rows), "a      b\nµm     7\nlong  12\n");
        let wide = "x".repeat(70_000);
        let text = super::text(&["a", "b"], vec![vec![wide.clone(), "c".to_owned()]]);
        assert_eq!(text.lines().nth(1), Some(format!("{wide}  c").as_str()));
    }
}
