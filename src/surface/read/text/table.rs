//! From the numbers of a block to heights: which of matrix, profile, points or columns they are.

use super::blocks::Chosen;
use super::coordinates;
use super::header::{Header, height_column, of_columns};
use super::layout;
use super::names::{Column, Role};
use super::numbers::{self, Table};
use super::points::{self, Fault};
use super::profile;
use crate::error::{Error, Result};
use crate::surface::check_pixels;
use crate::surface::raster::{Lateral, Raster, Samples, Stated};

/// A matrix of three columns with more rows than this is more likely scattered points.
const MOST_ROWS: usize = 48;

/// A profile with this many numbers in one line, if they would fill a square, is most likely a matrix.
const LONG_LINE: usize = 1024;

/// Heights of the chosen block.
pub(super) fn read(chosen: Chosen, channel: Option<&str>, subject: &str) -> Result<Raster> {
    let Chosen { header, segment, is_parted, is_named } = chosen;
    let channel = channel.filter(|_| !is_named);
    let (text, first_line) = (segment.text(), segment.first_line);
    let has_two_names = header.columns(2).is_some();
    let layout = layout::layout(text, first_line, has_two_names, subject)?;
    let table = numbers::table(text, first_line, layout, subject)?;
    let mut notes = Vec::new();
    if table.words > 0 {
        notes.push(format!("{} cells with words in place of numbers are void", table.words));
    }
    let names = header.columns(table.width);
    check_first_row(&header, &table, names.is_some(), subject)?;
    let mut raster = shape(table, &header, names, channel, is_parted, subject)?;
    notes.append(&mut raster.notes);
    raster.notes = notes;
    Ok(raster)
}

/// A line of words and numbers just above the numbers, as many as in a row: a damaged row, not a heading.
fn check_first_row(header: &Header, table: &Table, is_named: bool, subject: &str) -> Result<()> {
    let Some(last) = header.remarks.last().filter(|last| !last.is_comment && !is_named) else {
        return Ok(());
    };
    let fields: Vec<&str> =
        last.text.split([' ', '\t', ',', ';']).filter(|field| !field.is_empty()).collect();
    let has_number = fields.iter().any(|field| field.parse::<f64>().is_ok());
    if fields.len() != table.width || !has_number {
        return Ok(());
    }
    let word = fields.iter().find(|f| f.parse::<f64>().is_err()).copied().unwrap_or_default();
    let cause =
        format!("line {}: `{word}` is not a number, in a line like the rows of heights", last.line);
    Err(Error::new(subject, cause)
        .remedy("correct the number; start headings and comments with `#`"))
}

fn shape(
    table: Table,
    header: &Header,
    names: Option<Vec<Column>>,
    channel: Option<&str>,
    is_parted: bool,
    subject: &str,
) -> Result<Raster> {
    let error = |cause: String| Error::new(subject, cause);
    let pixels = header.pixels();
    let is_all = |count: usize| pixels.is_some_and(|(c, r)| c.checked_mul(r) == Some(count as u64));
    let is_sound = table.corner_fault.is_none();
    if let (true, Some((columns, rows))) = (is_sound && is_all(table.values.len()), pixels) {
        let (columns, rows) = check_pixels(subject, columns, rows)?;
        let mut stated = header.stated([columns, rows]);
        if let Some([only]) = header.columns(1).as_deref() {
            of_columns(&mut stated, std::slice::from_ref(only), None, 0);
        }
        return matrix(columns, rows, table.values, stated, channel, header, subject);
    }
    if let Some((line, width, first)) = table.ragged {
        return Err(numbers::ragged(subject, (line, width), (first, table.width)));
    }
    let names = names.as_deref();
    if let (Some(names), Some((columns, rows)), true) = (names, pixels, is_all(table.rows)) {
        let (columns, rows) = check_pixels(subject, columns, rows)?;
        return of_named(table, names, [columns, rows], header, channel, subject);
    }
    if is_sound && let Some(raster) = as_points(&table, names, header, channel, subject)? {
        return Ok(raster);
    }
    if is_parted && table.width == 3 {
        return Err(error("blank lines part the numbers, which are no points on a grid".into())
            .remedy("remove the blank lines, or choose a block with `channel = …`"));
    }
    if is_sound && let Some((step, heights)) = profile::find(&table, names, subject)? {
        let mut stated = header.stated([heights.len(), 1]);
        coordinates_of(&mut stated, [Some(step), None], "the first column of distances");
        if let Some(names) = names {
            of_columns(&mut stated, names, Some(0), 1);
        }
        let columns = check_pixels(subject, heights.len() as u64, 1)?.0;
        let notes = vec!["two columns are read as distance and height of a profile".to_owned()];
        return Ok(Raster { columns, rows: 1, samples: Samples::Float(heights), stated, notes });
    }
    if let Some(found) = coordinates::find(&table, subject)? {
        let (columns, rows, values) = coordinates::inside(table, &found);
        let (columns, rows) = check_pixels(subject, columns as u64, rows as u64)?;
        let mut stated = header.stated([columns, rows]);
        let steps = [Some(found.x.step.abs()), Some(found.y.step.abs())];
        coordinates_of(&mut stated, steps, "the coordinates in the first row and column");
        let notes = vec!["the first row and column are read as coordinates, y upwards".to_owned()];
        return Ok(Raster { columns, rows, samples: Samples::Float(values), stated, notes });
    }
    if let Some(fault) = table.corner_fault {
        return Err(fault);
    }
    if let Some((columns, rows)) = pixels {
        let cause = format!(
            "the header states {columns} × {rows} pixels, but there are {} numbers in {} lines",
            table.values.len(),
            table.rows
        );
        return Err(
            error(cause).remedy("the file is truncated, or its header is wrong; export it again")
        );
    }
    let (columns, rows) = check_pixels(subject, table.width as u64, table.rows as u64)?;
    let stated = header.stated([columns, rows]);
    matrix(columns, rows, table.values, stated, channel, header, subject)
}

fn matrix(
    columns: usize,
    rows: usize,
    values: Vec<f64>,
    stated: Stated,
    channel: Option<&str>,
    header: &Header,
    subject: &str,
) -> Result<Raster> {
    let is_named = |wanted: &str| {
        wanted.trim() == "1"
            || header.label().is_some_and(|label| label.trim().eq_ignore_ascii_case(wanted.trim()))
    };
    if let Some(wanted) = channel.filter(|wanted| !is_named(wanted)) {
        let has =
            header.label().map_or("one without a name".to_owned(), |label| format!("only {label}"));
        return Err(Error::new(
            subject,
            format!("`channel = {wanted}` is not in the file, which has {has}"),
        )
        .remedy("remove `channel`"));
    }
    let mut notes = Vec::new();
    let side = values.len().isqrt();
    if rows == 1 && columns >= LONG_LINE && side * side == columns {
        notes.push(format!(
            "all {columns} numbers stand on one line, so they are a profile; if they are a matrix of {side} × {side}, write `# x-pixels = {side}` and `# y-pixels = {side}` above them"
        ));
    }
    Ok(Raster { columns, rows, samples: Samples::Float(values), stated, notes })
}

/// Takes steps of coordinates as the pitch, unless the header states one.
fn coordinates_of(stated: &mut Stated, steps: [Option<f64>; 2], by: &str) {
    if stated.both().is_none() {
        stated.pitch = steps;
        stated.lateral = Lateral::LikeHeights;
        stated.pitch_by = by.to_owned();
    }
}

/// A table of named columns, one line for each of the pixels that the header states.
fn of_named(
    table: Table,
    names: &[Column],
    [columns, rows]: [usize; 2],
    header: &Header,
    channel: Option<&str>,
    subject: &str,
) -> Result<Raster> {
    let at = height_column(names, channel).ok_or_else(|| no_column(channel, names, subject))?;
    let values = table.values.iter().skip(at).step_by(table.width).copied().collect();
    let mut stated = header.stated([columns, rows]);
    of_columns(&mut stated, names, None, at);
    let notes = vec![format!("column `{}` of {} is used", names[at].label, names.len())];
    Ok(Raster { columns, rows, samples: Samples::Float(values), stated, notes })
}

fn no_column(channel: Option<&str>, names: &[Column], subject: &str) -> Error {
    let listed: Vec<&str> = names.iter().map(|column| column.label.as_str()).collect();
    let cause = format!(
        "`channel = {}` is not among the columns {}",
        channel.unwrap_or_default(),
        listed.join(", ")
    );
    Error::new(subject, cause).remedy("give the name of one of these columns")
}

/// Points x, y, z: three columns, or more of which the header names x and y.
fn as_points(
    table: &Table,
    names: Option<&[Column]>,
    header: &Header,
    channel: Option<&str>,
    subject: &str,
) -> Result<Option<Raster>> {
    let named = |role: Role| names?.iter().position(|column| column.role() == role);
    let is_named = named(Role::X).is_some() && named(Role::Y).is_some();
    if !(is_named && table.width >= 3 || table.width == 3 && table.rows >= 4) {
        return Ok(None);
    }
    let (x, y, z) = match (names, is_named) {
        (Some(names), true) => {
            let z = height_column(names, channel);
            let z = z.ok_or_else(|| no_column(channel, names, subject))?;
            (named(Role::X).unwrap_or(0), named(Role::Y).unwrap_or(1), z)
        }
        _ => (0, 1, 2),
    };
    let point = |i: usize| [x, y, z].map(|column| table.values[i * table.width + column]);
    let grid = match points::grid(table.rows, point, subject)? {
        Ok(grid) => grid,
        Err(Fault::Words(words)) if is_named || table.rows > MOST_ROWS => {
            return Err(points::refuse(&words, subject));
        }
        Err(_) if is_named => {
            return Err(points::refuse("the points lie on no regular grid", subject));
        }
        Err(_) if table.rows > MOST_ROWS => {
            let cause = format!(
                "{} rows of three numbers may be points x y z, which then lie on no regular grid, or a matrix of three columns",
                table.rows
            );
            return Err(points::refuse(&cause, subject));
        }
        Err(_) => return Ok(None),
    };
    let mut stated = header.stated([grid.columns, grid.rows]);
    coordinates_of(&mut stated, grid.pitch.map(Some), "the points' coordinates");
    if let Some(names) = names {
        of_columns(&mut stated, names, is_named.then_some(x), z);
    }
    let notes = vec![format!(
        "{} points x y z are read as {} × {} pixels, y upwards",
        table.rows, grid.columns, grid.rows
    )];
    let points::Grid { columns, rows, values, .. } = grid;
    Ok(Some(Raster { columns, rows, samples: Samples::Float(values), stated, notes }))
}
