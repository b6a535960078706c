//! Blocks of numbers, one for each channel, separated by headers or blank lines. One is chosen. Blocks are never joined.

use super::decode::{self, Line, line, lines};
use super::even::Even;
use super::header::Header;
use super::names;
use crate::error::{Error, Result};

/// No program writes more channels than this into one file.
const MAX_BLOCKS: usize = 1000;

/// A header and the numbers below it.
pub(super) struct Block<'t> {
    pub header: Header,
    pub segments: Vec<Segment<'t>>,
}

/// Lines of numbers without a blank line between them.
#[derive(Clone, Copy)]
pub(super) struct Segment<'t> {
    pub first_line: usize,
    pub rows: usize,
    start: usize,
    end: usize,
    whole: &'t str,
}

impl<'t> Segment<'t> {
    pub fn text(&self) -> &'t str {
        &self.whole[self.start..self.end]
    }

    /// From the beginning of this segment to the end of another.
    fn up_to(&self, last: &Segment) -> Segment<'t> {
        Segment { rows: self.rows.max(last.rows), end: last.end, ..*self }
    }
}

/// What was chosen.
pub(super) struct Chosen<'t> {
    pub header: Header,
    pub segment: Segment<'t>,
    /// Whether blank lines part the numbers, as around the lines of points.
    pub is_parted: bool,
    /// Whether it is the one that the plan's `channel` names.
    pub is_named: bool,
}

/// Splits a text. Lines of words between rows of numbers are errors.
pub(super) fn split<'t>(text: &'t str, subject: &str) -> Result<Vec<Block<'t>>> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut header = Header::default();
    // whether lines since the last numbers said something
    let (mut spoke, mut gap) = (true, true);
    for (number, raw) in lines(text) {
        match line(raw) {
            Line::Blank => gap = true,
            found @ (Line::Comment(words) | Line::Words(words)) if !is_coordinates(&found) => {
                let is_comment = matches!(found, Line::Comment(_));
                if !spoke && !gap && !Header::begins_block(words) {
                    if is_comment {
                        continue;
                    }
                    let shown: String = words.chars().take(40).collect();
                    let cause = format!("line {number}: `{shown}` is not a number");
                    return Err(Error::new(subject, cause)
                        .remedy("write numbers only; start headings and comments with `#`"));
                }
                header.add(number, words, is_comment);
                spoke = true;
            }
            _ => {
                let start = raw.as_ptr() as usize - text.as_ptr() as usize;
                if spoke {
                    let mut own = std::mem::take(&mut header);
                    if let Some(last) = blocks.last() {
                        own.inherit(&last.header);
                    }
                    if blocks.len() == MAX_BLOCKS {
                        let cause =
                            format!("the file has more than {MAX_BLOCKS} blocks of numbers");
                        return Err(
                            Error::new(subject, cause).remedy("save the block of heights alone")
                        );
                    }
                    blocks.push(Block { header: own, segments: Vec::new() });
                }
                if let Some(block) = blocks.last_mut() {
                    if spoke || gap {
                        block.segments.push(Segment {
                            first_line: number,
                            rows: 0,
                            start,
                            end: start,
                            whole: text,
                        });
                    }
                    if let Some(segment) = block.segments.last_mut() {
                        segment.rows += 1;
                        segment.end = start + raw.len();
                    }
                }
                (spoke, gap) = (false, false);
            }
        }
    }
    if let Some(last) = blocks.last_mut() {
        last.header.append(header);
    }
    Ok(blocks)
}

/// Chooses the block that the plan names, the only one, or the first if it says that it holds heights.
pub(super) fn choose<'t>(
    blocks: Vec<Block<'t>>,
    channel: Option<&str>,
    subject: &str,
    notes: &mut Vec<String>,
) -> Result<Chosen<'t>> {
    let mut all: Vec<(Option<String>, Chosen)> = blocks.into_iter().flat_map(candidates).collect();
    if all.is_empty() {
        return Err(Error::new(subject, "the file has no numbers")
            .remedy("write one row of heights per line"));
    }
    let listed = |all: &[(Option<String>, Chosen)]| -> String {
        let of = |(at, (label, chosen)): (usize, &(Option<String>, Chosen))| {
            let label = label.as_deref().unwrap_or("no name");
            let Segment { rows, first_line, .. } = chosen.segment;
            format!("{}: {label} (line {first_line}, {rows} rows)", at + 1)
        };
        all.iter().enumerate().take(20).map(of).collect::<Vec<_>>().join("; ")
    };
    let Some(wanted) = channel.map(str::trim) else {
        let is_first = all.len() == 1 || all[0].0.as_deref().is_some_and(names::is_height);
        if !is_first {
            let cause = format!("the file has {} blocks of numbers: {}", all.len(), listed(&all));
            return Err(Error::new(subject, cause).remedy(
                "choose one by name or number with `channel = …`; blank lines within one block have to be removed",
            ));
        }
        if all.len() > 1 {
            notes.push(format!("the first of {} blocks is used: {}", all.len(), listed(&all)));
        }
        return Ok(all.swap_remove(0).1);
    };
    let by_name = all.iter().position(|(label, _)| {
        label.as_deref().is_some_and(|label| label.trim().eq_ignore_ascii_case(wanted))
    });
    let by_number = || wanted.parse::<usize>().ok().filter(|n| (1..=all.len()).contains(n));
    match by_name.or_else(|| by_number().map(|n| n - 1)) {
        Some(at) => Ok(Chosen { is_named: true, ..all.swap_remove(at).1 }),
        // a column of the only block may have that name
        None if all.len() == 1 => Ok(all.swap_remove(0).1),
        None => {
            let cause =
                format!("`channel = {wanted}` is not in the file, which has {}", listed(&all));
            Err(Error::new(subject, cause)
                .remedy("give the name or the number of one of these blocks"))
        }
    }
}

/// The channels of a block: its segments, unless every row stands alone, the header tells the number of pixels, or
/// blank lines part points.
fn candidates<'t>(block: Block<'t>) -> Vec<(Option<String>, Chosen<'t>)> {
    let Block { header, segments } = block;
    let label = header.label();
    let is_one = segments.iter().all(|segment| segment.rows == 1)
        || header.pixels().is_some()
        || is_points(&segments, &header);
    let chosen = |segment: Segment<'t>, is_parted| Chosen {
        header: header.clone(),
        segment,
        is_parted,
        is_named: false,
    };
    match segments.as_slice() {
        [] => Vec::new(),
        [only] => vec![(label, chosen(*only, false))],
        [first, .., last] if is_one => {
            let mut whole = first.up_to(last);
            whole.rows = segments.iter().map(|segment| segment.rows).sum();
            vec![(label, chosen(whole, true))]
        }
        _ => segments.iter().map(|segment| (None, chosen(*segment, false))).collect(),
    }
}

/// Whether a line is a word and evenly spaced numbers: coordinates beside the name of their corner.
fn is_coordinates(line: &Line) -> bool {
    let Line::Words(words) = line else { return false };
    let fields = decode::fields(words);
    let numbers: Option<Vec<f64>> = fields.get(1..).and_then(|rest| {
        rest.iter().map(|field| field.replacen(',', ".", 1).parse().ok()).collect()
    });
    numbers.is_some_and(|numbers| numbers.len() > 2 && Even::within(&numbers, 1e-3).is_some())
}

/// Whether the first line looks like a point, x y z.
fn is_points(segments: &[Segment], header: &Header) -> bool {
    let Some(first) = segments.first() else { return false };
    let text = first.text();
    decode::fields(text.lines().next().unwrap_or_default()).len() == 3
        || header.columns(3).is_some()
}
