//! Pictures inside the page, each of them once.

use std::collections::BTreeMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use super::source::Folder;

/// What is to be seen where a record names a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Picture {
    /// The picture of this number.
    Drawn(usize),
    /// None, since it cannot be read.
    Missing,
    /// None, since the page was asked to be without.
    Left,
}

/// The pictures of a page. A map is shown in several places, so its bytes are in the style sheet and each place names its
/// class.
#[derive(Debug, Default)]
pub(super) struct Album {
    numbers: BTreeMap<Vec<u8>, usize>,
}

impl Album {
    /// Takes a picture in; the same bytes have the same number.
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

    /// The style sheet of the pictures, in the order in which they came.
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

/// A picture of a form of its own.
pub(super) fn shown(picture: &Picture, alt: &str, class: &str) -> Markup {
    html! {
        @match picture {
            Picture::Drawn(number) => div class={ (class) " p" (number) } role="img" aria-label=(alt) {},
            Picture::Missing => div class={ (class) " hole" } { "picture missing" },
            Picture::Left => div class={ (class) " hole" } { "left out" },
        }
    }
}
