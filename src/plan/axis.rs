//! A key of the product: the words that it takes, and its reader.

use super::item::Item;
use super::variants::Setting;
use super::words::{self, names};

/// A key: the words that it takes, and its reader.
#[derive(Clone, Copy)]
pub(super) struct Axis {
    pub(super) key: &'static str,
    pub(super) words: fn() -> Vec<&'static str>,
    pub(super) read: fn(&Item) -> Option<Setting>,
}

/// A key that takes words alone; those that it tells are those that it reads.
macro_rules! worded {
    ($key:literal, $words:expr, $setting:expr) => {
        $crate::plan::axis::Axis {
            key: $key,
            words: || $crate::plan::words::names($words),
            read: |item| item.word($words).map($setting),
        }
    };
}

/// A key that takes no words.
pub(super) const fn values(key: &'static str, read: fn(&Item) -> Option<Setting>) -> Axis {
    Axis { key, words: Vec::new, read }
}

/// A key that takes values, or `auto`.
pub(super) const fn values_or_auto(key: &'static str, read: fn(&Item) -> Option<Setting>) -> Axis {
    Axis { key, words: || names(words::AUTO), read }
}

pub(super) use worded;
