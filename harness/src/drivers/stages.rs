//! Finds the emitted files of a pipeline.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::shader::emit::EmittedFile;
use diffraction_shaders::shader::module;

/// A file and the name of one of its entry points.
pub(super) type StageFile<'a> = (&'a EmittedFile, &'a str);

/// The file with the first vertex entry point, which covers the screen, and the file with the fragment entry point `entry`.
/// `name` is the variant's name, for errors.
pub(super) fn stages<'a>(
    name: &str,
    files: &'a [EmittedFile],
    entry: &str,
) -> Result<[StageFile<'a>; 2]> {
    let find = |stage: module::Stage, wanted: Option<&str>| {
        let of_file = |file: &'a EmittedFile| {
            let mut points = file.entry_points.iter();
            let point = points.find(|point| {
                point.stage == stage && wanted.is_none_or(|name| name == point.source_name)
            });
            point.map(|point| (file, point.emitted_name.as_str()))
        };
        files.iter().find_map(of_file).ok_or_else(|| {
            let cause = format!("no emitted file has {}", wanted.unwrap_or("a vertex stage"));
            Error::new(name, cause)
        })
    };
    Ok([find(module::Stage::Vertex, None)?, find(module::Stage::Fragment, Some(entry))?])
}
