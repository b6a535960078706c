//! `cargo xtask explain`: shows a variant's generated shader beside the template lines that it came from.

use std::num::NonZeroUsize;

use anyhow::{Context, Result, bail};
use diffraction_shaders::diagnostic::{Diagnostic, Diagnostics};
use diffraction_shaders::input;
use diffraction_shaders::shader::specialise;
use diffraction_shaders::shader::template::{Origin, Sources, Specialised, specialise};
use diffraction_shaders::variant::Form;

use crate::Outcome;
use crate::args::PlanArgs;
use crate::console::Console;

const EXAMPLE: &str = "Examples:
  cargo xtask explain full-taylor-t19
  cargo xtask explain full-taylor-t19 --surface cd --line 40

Each line of the output: the line number in diffraction.wgsl, the template file with its line number, the text.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    plan: PlanArgs,
    /// Name of the variant, as in the plan.
    #[arg(value_name = "VARIANT")]
    variant: String,
    /// Name of the surface, as in the plan. Default: the first surface that has the variant. Shaders of two surfaces differ in
    /// constants only.
    #[arg(long, value_name = "NAME")]
    surface: Option<String>,
    /// Show only this line of diffraction.wgsl, with the whole template line.
    #[arg(long, value_name = "N")]
    line: Option<NonZeroUsize>,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let plan = args.plan.read(console)?;
    let spec = match &args.surface {
        Some(name) => plan.surface(name)?,
        None => {
            let wanted = plan.variant(Some(&args.variant))?;
            let first = plan.surfaces.iter().find(|surface| wanted.is_for(&surface.name));
            first.context("the plan has no surface")?
        }
    };
    let variant = plan.on(spec).variant(Some(&args.variant))?;
    let loaded = input::load_surface(spec)?;
    let form = Form::new(&variant, &loaded.field)?;
    let nodes = specialise::node_count(&specialise::shapes(&form, spec.rotate_deg));
    let defines = specialise::defines(&variant, &form, spec.rotate_deg, nodes);
    let sources = Sources::builtin();
    let label = format!("{} {}", spec.name, variant.name);
    let named = |all: Vec<Diagnostic>| all.into_iter().map(|d| d.variant(&label)).collect();
    let specialised =
        specialise(&sources, specialise::ROOT, &defines).map_err(|all| Diagnostics(named(all)))?;
    let text = match args.line {
        Some(line) => one(&specialised, &sources, line.get())
            .with_context(|| format!("--line {line}: {label}"))?,
        None => all(&specialised),
    };
    console.data(&text)?;
    Ok(Outcome::Done)
}

/// `line  template:line  text` for every line. The text stands last, so that a narrow terminal wraps or cuts only the
/// text. Templates keep to 120 columns.
fn all(specialised: &Specialised) -> String {
    let lines = specialised.text.lines().zip(&specialised.origins);
    let rows: Vec<(String, String, &str)> = (1..)
        .zip(lines)
        .map(|(number, (text, origin)): (usize, _)| (number.to_string(), place(origin), text))
        .collect();
    let width = |column: fn(&(String, String, &str)) -> usize| rows.iter().map(column).max();
    let numbers = width(|row| row.0.len()).unwrap_or(0);
    let places = width(|row| row.1.len()).unwrap_or(0);
    let line = |(number, place, text): &(String, String, &str)| {
        let row = format!("{number:>numbers$}  {place:<places$}  {text}");
        row.trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

/// One line of the text, then the line of its template, which may be a directive.
fn one(specialised: &Specialised, sources: &Sources, line: usize) -> Result<String> {
    let lines: Vec<&str> = specialised.text.lines().collect();
    let (Some(text), Some(origin)) = (lines.get(line - 1), specialised.origins.get(line - 1))
    else {
        bail!("diffraction.wgsl has {} lines only", lines.len());
    };
    let template = sources.place(&origin.file, origin.line, 1).text;
    let places = [format!("diffraction.wgsl:{line}"), Sources::path(&origin.file)];
    let [generated, path] = places;
    let from = format!("{path}:{}", origin.line);
    let width = generated.len().max(from.len());
    let row = |place: &str, text: &str| format!("{place:<width$}  {text}").trim_end().to_owned();
    Ok(format!("{}\n{}\n", row(&generated, text), row(&from, &template)))
}

fn place(origin: &Origin) -> String {
    format!("{}:{}", Sources::path(&origin.file), origin.line)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn specialised() -> (Specialised, Sources) {
        let sources: Sources = [
            ("shader", "// Top.\n#constants\n#import longer\n"),
            ("longer", "#ifdef ON\nfn a() -> i32 {\n    return N;\n}\n#endif\n"),
        ]
        .into_iter()
        .collect();
        let mut defines = diffraction_shaders::shader::template::Defines::default();
        defines.flag("ON", true);
        defines.count("N", 7, "days");
        (specialise(&sources, "shader", &defines).unwrap(), sources)
    }

    #[test]
    fn columns_are_aligned_and_tell_where_lines_come_from() {
        let (specialised, _) = specialised();
        let expected = "\
1  templates/shader.wgsl:1  // @generated by `cargo xtask generate`; do not edit
2  templates/shader.wgsl:1  // Top.
3  templates/shader.wgsl:2  const N: i32 = 7; // days
4  templates/longer.wgsl:2  fn a() -> i32 {
5  templates/longer.wgsl:3      return N;
6  templates/longer.wgsl:4  }
";
        assert_eq!(all(&specialised), expected);
    }

    #[test]
    fn one_line_beside_its_template_line() {
        let (specialised, sources) = specialised();
        assert_eq!(
            one(&specialised, &sources, 3).unwrap(),
            "diffraction.wgsl:3       const N: i32 = 7; // days\ntemplates/shader.wgsl:2  #constants\n"
        );
        let error = one(&specialised, &sources, 7).unwrap_err();
        assert_eq!(error.to_string(), "diffraction.wgsl has 6 lines only");
    }
}
