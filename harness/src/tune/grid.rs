//! The grid of candidates: keys of a preset with their values, as TOML.

/// Keys of a preset and the values of each. The candidates are their product; the first key varies slowest.
pub(super) type Grid = &'static [Choices];

/// A key and its values, as TOML.
pub(super) type Choices = (&'static str, &'static [&'static str]);

/// All grids. Words that this version does not know are tried as well: its parser refuses them with a reason.
pub(super) const GRIDS: [Grid; 6] = [
    // one or a few lookups
    &[
        ("mode", &["\"baked\""]),
        ("sampling", &["\"filter\"", "\"load\""]),
        ("table", &["\"f16\"", "\"f32\"", "\"rgb9e5\""]),
    ],
    // orders of a cell that has few of them
    &[("mode", &["\"orders\""]), ("lights", &["[\"direction\"]"])],
    // the bins near the path of a direction's wavelengths
    &[("mode", &["\"adaptive\""]), BASIS, TERMS, TABLE],
    // the window applied in space
    &[
        FULL,
        ("reconstruction", &["\"prefiltered\""]),
        ("sampling", &["\"filter\"", "\"load\""]),
        BASIS,
        TERMS,
        STEPS,
        TABLE,
    ],
    // the window as a sum over bins
    &[FULL, BASIS, TERMS, ("window_radius", &["0", "1", "2", "\"auto\""]), STEPS, TABLE],
    // replicas of the patch: their lobes differ from the window's, so few are worth trying
    &[
        ("mode", &["\"pq\""]),
        ("basis", &["\"optimal\""]),
        TERMS,
        ("window_radius", &["1", "\"auto\""]),
        ("wavelengths", &["5", "2.5"]),
        ("table", &["\"f16\""]),
    ],
];

const FULL: Choices = ("mode", &["\"full\""]);
const BASIS: Choices = ("basis", &["\"optimal\"", "\"chebyshev\"", "\"taylor\""]);
const TABLE: Choices = ("table", &["\"f16\"", "\"f32\""]);

/// Steps of the wavelength, nm. In a preset they are in the table `wavelengths`.
const STEPS: Choices = ("wavelengths", &["10", "5", "2.5", "1.25"]);

/// Errors of the phase function on the surface, to be replaced by numbers of terms; and `"auto"`.
const TERMS: Choices = ("terms", &["0.3", "0.1", "0.03", "0.01", "\"auto\""]);

/// The whole visible range with a step, as TOML.
pub(super) fn wavelengths(step_nm: &str) -> String {
    format!("{{ min_nm = 380, max_nm = 780, step_nm = {step_nm} }}")
}

/// The product of a grid: lists of keys with values.
pub(super) fn product(grid: Grid) -> Vec<Vec<(&'static str, &'static str)>> {
    grid.iter().fold(vec![Vec::new()], |rows, (key, values)| {
        let with = |row: &Vec<_>| {
            let row = row.clone();
            values.iter().map(move |value| [row.clone(), vec![(*key, *value)]].concat())
        };
        rows.iter().flat_map(with).collect()
    })
}

/// A name for a candidate: its words and numbers, without defaults.
pub(super) fn name(keys: &[(&str, String)]) -> String {
    let part = |(key, value): &(&str, String)| {
        let word = value.trim_matches('"').replace('.', "p");
        match *key {
            "terms" => Some(format!("t{word}")),
            "window_radius" => Some(format!("r{word}")),
            "wavelengths" => Some(format!("by{word}")),
            "table" if word == "f32" => None,
            "lights" => None,
            _ => Some(word),
        }
    };
    keys.iter().filter_map(part).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_products_whole() {
        let rows: Vec<_> = GRIDS.into_iter().flat_map(product).collect();
        assert_eq!(rows.len(), 6 + 1 + 30 + 240 + 480 + 20);
        let mut names: Vec<String> = rows
            .iter()
            .map(|row| name(&row.iter().map(|(k, v)| (*k, (*v).to_owned())).collect::<Vec<_>>()))
            .collect();
        assert_eq!(names[0], "baked-filter-f16");
        assert_eq!(names[rows.len() - 1], "pq-optimal-tauto-rauto-by2p5-f16");
        names.sort();
        names.dedup();
        assert_eq!(names.len(), rows.len());
    }
}
