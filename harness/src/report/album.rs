//! Pictures inside the page, each stored once.

use std::collections::BTreeMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use super::source::Folder;

/// What the page shows in place of a picture of a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Picture {
    /// The picture with this number.
    Drawn(usize),
    /// A note that the picture cannot be read.
    Missing,
    /// A note that pictures are left out on request.
    Left,
}

/// The pictures of a page. A map is shown in several places, so its bytes are in the style sheet and each place refers to its
/// class.
#[derive(Debug, Default)]
pub(super) struct Album {
    numbers: BTreeMap<Vec<u8>, usize>,
}

impl Album {
    /// Adds a picture. The same bytes get the same number.
    pub(super) fn add(&mut self, folder: &Folder, place: &str) -> Picture {
        match folder.pictures.get(place) {
            Some(Ok(bytes)) => {
                let next = self.numbers.len();
                Picture::Drawn(*self.numbers.entry(bytes.clone()).or_insert(next))
            }
            Some(Err(_)) => Picture::Missing,
            None => Picture::Left,
        }
    }

    /// The style sheet of the pictures, in the order in which they were added.
    pub(super) fn css(&self) -> String {
        let mut ordered: Vec<(&usize, &Vec<u8>)> =
            self.numbers.iter().map(|(bytes, number)| (number, bytes)).collect();
        ordered.sort_unstable();
        let mut css = String::new();
        for (number, bytes) in ordered {
            let kind = if bytes.starts_with(b"\x89PNG") { "png" } else { "svg+xml" };
            let data = STANDARD.encode(bytes);
            css += &format!(
                ".p{number}{{background-image:url(\"data:image/{kind};base64,{data}\")}}\n"
            );
        }
        css
    }
}

/// A square map.
pub(super) fn map(picture: &Picture, alt: &str) -> Markup {
    shown(picture, alt, "map")
}

/// A picture that is not a square map.
pub(super) fn shown(picture: &Picture, alt: &str, class: &str) -> Markup {
    html! {
        @match picture {
            Picture::Drawn(number) => div class={ (class) " p" (number) } role="img" aria-label=(alt) {},
            Picture::Missing => div class={ (class) " hole" } { "picture missing" },
            Picture::Left => div class={ (class) " hole" } { "left out" },
        }
    }
}
