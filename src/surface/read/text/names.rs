//! Names of columns, with their units: `x y z in um`, `X[nm]`, `distance_um,height_um`, `Height (nm)`.

use crate::surface::length::{Unit, unit};

/// A named column.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    /// Letters and digits of the name, in lower case.
    pub name: String,
    /// As written, for messages.
    pub label: String,
    pub unit: Option<Unit>,
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    X,
    Y,
    Height,
    Other,
}

impl Column {
    pub fn role(&self) -> Role {
        match self.name.as_str() {
            "x" | "xposition" | "xpos" | "xcoordinate" | "distance" | "position" | "lateral"
            | "length" | "offset" | "abscissa" | "scanlength" | "lateralposition" => Role::X,
            "y" | "yposition" | "ypos" | "ycoordinate" => Role::Y,
            "z" | "zposition" | "zpos" | "elevation" | "profile" | "relief" => Role::Height,
            name if is_height(name) => Role::Height,
            _ => Role::Other,
        }
    }
}

/// Whether a channel's name says that it holds heights.
pub(super) fn is_height(name: &str) -> bool {
    let name = name.to_lowercase();
    ["height", "topo", "höhe", "hauteur", "výška", "altezza", "altura"]
        .iter()
        .any(|word| name.contains(word))
        || matches!(name.trim(), "z" | "zsensor" | "z sensor")
}

/// The columns that a line names. Nothing if a field of it is a number.
pub(super) fn columns(line: &str) -> Option<Vec<Column>> {
    let line = line.trim().trim_start_matches(['#', '%', '/', '!', '*', ' ']);
    let (line, common) = match line.rsplit_once(" in ") {
        Some((names, words)) => match unit(words) {
            Unit::Length(um) => (names, Some(Unit::Length(um))),
            Unit::Other(_) => (line, None),
        },
        None => (line, None),
    };
    let separator = ['\t', ';', ','].into_iter().find(|&c| line.contains(c));
    let fields: Vec<String> = match separator {
        Some(separator) => line.split(separator).map(|f| f.trim().to_owned()).collect(),
        None => words(line),
    };
    let columns: Vec<Column> =
        fields.iter().filter(|f| !f.is_empty()).map(|field| column(field, &common)).collect();
    let is_sound = columns.iter().all(|c| c.name.starts_with(|first: char| first.is_alphabetic()));
    (is_sound && !columns.is_empty()).then_some(columns)
}

/// Fields between blanks; a unit in brackets belongs to the word before it.
fn words(line: &str) -> Vec<String> {
    let mut fields: Vec<String> = Vec::new();
    for word in line.split_whitespace() {
        match fields.last_mut() {
            Some(last) if word.starts_with(['(', '[']) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => fields.push(word.to_owned()),
        }
    }
    fields
}

fn column(field: &str, common: &Option<Unit>) -> Column {
    let field = field.trim_matches('"').trim();
    let (name, words) = if let Some(at) = field.find(['[', '(']) {
        (&field[..at], Some(&field[at..]))
    } else if let Some((name, words)) = field.rsplit_once(['/', '_', ' ']) {
        match unit(words) {
            Unit::Length(_) => (name, Some(words)),
            Unit::Other(_) => (field, None),
        }
    } else {
        (field, None)
    };
    Column {
        name: name.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect(),
        label: name.trim().to_owned(),
        unit: words.map(unit).or_else(|| common.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_units_of_columns() {
        let um = |um: f64| Some(Unit::Length(um));
        for (line, wanted) in [
            ("x y z in um", vec![("x", um(1.0)), ("y", um(1.0)), ("z", um(1.0))]),
            ("X[nm]\tY[nm]\tZ[pm]", vec![("x", um(1e-3)), ("y", um(1e-3)), ("z", um(1e-6))]),
            ("x (µm) y (µm) z (nm)", vec![("x", um(1.0)), ("y", um(1.0)), ("z", um(1e-3))]),
            ("# distance_um,height_nm", vec![("distance", um(1.0)), ("height", um(1e-3))]),
            ("Height_Sensor(nm)", vec![("heightsensor", um(1e-3))]),
            ("x/mm y/mm phase", vec![("x", um(1e3)), ("y", um(1e3)), ("phase", None)]),
        ] {
            let found = columns(line).unwrap();
            let found: Vec<_> = found.iter().map(|c| (c.name.as_str(), c.unit.clone())).collect();
            assert_eq!(found, wanted, "{line}");
        }
        assert_eq!(columns("1 2 3"), None);
        assert_eq!(columns("x 2 3"), None);
    }
}
