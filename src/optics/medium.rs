//! Refractive indices over the wavelength: numbers, tables of papers, tables of users.
//!
//! The tables of `constants/` have their sources in their first lines. Between two rows n and k are linear in the
//! wavelength. Beyond the first or last row the index of that row is kept.

use csv::{ReaderBuilder, StringRecord, Trim};
use rustfft::num_complex::Complex64;

use crate::error::{Error, Result};
use crate::plan::{Data, Medium};

/// The media that are part of the program, by the names of the plan.
const NAMED: [(&str, &str); 8] = [
    ("aluminium", include_str!("constants/aluminium.csv")),
    ("silver", include_str!("constants/silver.csv")),
    ("gold", include_str!("constants/gold.csv")),
    ("copper", include_str!("constants/copper.csv")),
    ("nickel", include_str!("constants/nickel.csv")),
    ("chromium", include_str!("constants/chromium.csv")),
    ("polycarbonate", include_str!("constants/polycarbonate.csv")),
    ("pmma", include_str!("constants/pmma.csv")),
];

/// Columns of a table, in any order. Further columns are ignored.
const COLUMNS: [&str; 3] = ["wavelength_nm", "n", "k"];

/// Largest part of a refractive index that a table may have. Beyond, the unit is probably another one.
const MAX_INDEX: f64 = 100.0;

/// A complex refractive index n + ik over the wavelength; k is positive where light is absorbed.
#[derive(Clone, Debug, PartialEq)]
pub enum Index {
    /// The same at every wavelength.
    Constant(Complex64),
    /// Rows of ascending wavelength in nm, at least two.
    Rows(Vec<(f64, Complex64)>),
}

impl Index {
    /// The index of a medium. The file of a medium must have been read.
    ///
    /// `subject`: what the medium is of, for errors.
    pub fn new(subject: &str, medium: &Medium) -> Result<Index> {
        match medium {
            Medium::Constant(n) => Ok(Index::Constant(Complex64::new(*n, 0.0))),
            Medium::File(data) => from_file(subject, data),
            Medium::Named(name) => {
                let text = NAMED.iter().find(|(known, _)| known == name).map(|(_, text)| *text);
                let text = text.ok_or_else(|| Error::new(subject, "is not a known medium"))?;
                rows(subject, text.as_bytes())
            }
        }
    }

    /// The index at a wavelength, nm.
    pub fn at(&self, lambda_nm: f64) -> Complex64 {
        let rows = match self {
            Index::Constant(index) => return *index,
            Index::Rows(rows) => rows,
        };
        let next = rows.partition_point(|(nm, _)| *nm < lambda_nm).clamp(1, rows.len() - 1);
        let ((from_nm, from), (to_nm, to)) = (rows[next - 1], rows[next]);
        let part = ((lambda_nm - from_nm) / (to_nm - from_nm)).clamp(0.0, 1.0);
        from + (to - from) * part
    }

    /// First and last wavelength of its table, nm. `None` if it is constant.
    pub fn range_nm(&self) -> Option<[f64; 2]> {
        match self {
            Index::Constant(_) => None,
            Index::Rows(rows) => Some([rows[0].0, rows[rows.len() - 1].0]),
        }
    }
}

/// Remedy for a table that cannot be used.
const REMEDY: &str = "give a CSV file with the header wavelength_nm,n,k, one line for each wavelength in ascending order, n above 0, \
                      k at least 0";

fn from_file(subject: &str, data: &Data) -> Result<Index> {
    match data.content() {
        Some(content) => rows(subject, content),
        None => Err(Error::new(subject, "the table of n and k was not read").remedy(REMEDY)),
    }
}

/// The rows of a table of n and k.
fn rows(subject: &str, content: &[u8]) -> Result<Index> {
    let fail = |cause: String| Error::new(subject, cause).remedy(REMEDY);
    let mut reader = ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(Trim::All)
        .flexible(true)
        .from_reader(content);
    let header = reader.headers().map_err(|e| fail("is not a table of text".into()).source(e))?;
    let place = |name: &str| header.iter().position(|field| field == name);
    let missing: Vec<&str> = COLUMNS.into_iter().filter(|name| place(name).is_none()).collect();
    if !missing.is_empty() {
        return Err(fail(format!(
            "its header is {:?}, without {}",
            header.iter().collect::<Vec<_>>().join(","),
            missing.join(", ")
        )));
    }
    let places = COLUMNS.map(|name| place(name).unwrap_or_default());
    let mut rows: Vec<(f64, Complex64)> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| fail("is not a table of text".into()).source(e))?;
        let line = record.position().map_or(0, |position| position.line());
        let row = row(&record, places).map_err(|cause| fail(format!("line {line}: {cause}")))?;
        if let Some((before, _)) = rows.last().filter(|(before, _)| *before >= row.0) {
            let cause = format!("line {line}: {} nm is not above the {before} nm before it", row.0);
            return Err(fail(cause));
        }
        rows.push(row);
    }
    if rows.len() < 2 {
        return Err(fail(format!("has {} lines of numbers, fewer than two", rows.len())));
    }
    Ok(Index::Rows(rows))
}

fn row(record: &StringRecord, places: [usize; 3]) -> Result<(f64, Complex64), String> {
    let number = |column: usize| {
        let field = record.get(places[column]).unwrap_or_default();
        let number = field.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| format!("{} is {field:?}, not a number", COLUMNS[column]))
    };
    let (nm, n, k) = (number(0)?, number(1)?, number(2)?);
    let out = |column: usize, value: f64, must: &str| {
        Err(format!("{} is {value}, which must be {must}", COLUMNS[column]))
    };
    match () {
        () if !(10.0..=1e6).contains(&nm) => out(0, nm, "from 10 to 1000000; is it in nm?"),
        () if !(n > 0.0 && n <= MAX_INDEX) => out(1, n, "above 0 and at most 100"),
        () if !(0.0..=MAX_INDEX).contains(&k) => {
            out(2, k, "from 0 to 100; k is positive where light is absorbed")
        }
        () => Ok((nm, Complex64::new(n, k))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_medium_of_the_program_covers_visible_light_from_400_nm() {
        for (name, _) in NAMED {
            let index = Index::new(name, &Medium::Named(name)).expect("valid");
            let [first, last] = index.range_nm().expect("a table");
            assert!(first <= 400.0 && last >= 780.0, "{name}: {first} to {last} nm");
        }
    }

    #[test]
    fn rows_are_linear_between_and_kept_beyond() {
        let text = "# a comment\nk, wavelength_nm, n\n2, 500, 1\n4, 600, 2\n";
        let index = rows("test", text.as_bytes()).expect("valid");
        for (nm, n, k) in
            [(400.0, 1.0, 2.0), (550.0, 1.5, 3.0), (600.0, 2.0, 4.0), (900.0, 2.0, 4.0)]
        {
            assert_eq!(index.at(nm), Complex64::new(n, k), "{nm} nm");
        }
    }

    #[test]
    fn wrong_tables_say_where_and_why() {
        for (text, want) in [
            ("", "without wavelength_nm, n, k"),
            ("nm,n,k\n1,2,3\n", "without wavelength_nm"),
            ("wavelength_nm,n\n500,1\n", "without k"),
            ("wavelength_nm,n,k\n500,1,0\n", "fewer than two"),
            ("wavelength_nm,n,k\n500,1,0\n500,1,0\n", "line 3: 500 nm is not above"),
            ("wavelength_nm,n,k\n600,1,0\n500,1,0\n", "line 3: 500 nm is not above"),
            ("wavelength_nm,n,k\n500,1,-1\n", "line 2: k is -1"),
            ("# c\nwavelength_nm,n,k\n500,0,1\n", "line 3: n is 0"),
            ("wavelength_nm,n,k\n500,NaN,1\n", "line 2: n is \"NaN\""),
            ("wavelength_nm,n,k\n500,1\n", "line 2: k is \"\""),
            ("wavelength_nm,n,k\n0.5,1,0\n", "is it in nm?"),
            ("wavelength_nm,n,k\n500,1e9,0\n", "at most 100"),
        ] {
            let message = rows("x.csv", text.as_bytes()).expect_err(text).to_string();
            assert!(message.contains(want) && message.contains("x.csv"), "{text:?}: {message}");
        }
    }
}
