//! How variants compute colours: a [`Form`] for each way, with its counts, template constants, tables, cost, tolerances
//! and description; the [`Function`]s that shaders offer; and the [`Twin`], the algorithm of each form in f64.

mod bound;
mod coat;
mod computation;
mod cost;
mod forms;
mod functions;
mod judge;
mod lay;
mod pattern;
mod prefilter;
mod tolerance;
mod twin;

pub use bound::{
    AUTO_TAIL, AUTO_TAIL_PQ, ErrorBound, ISOLATED, LobeBounds, environment_error, nodes_for,
    replica_tail, window_tail,
};
pub use coat::Coat;
pub use computation::{Computation, Ground};
pub use cost::Cost;
pub use forms::*;
pub use functions::{
    Arguments, Around, Coloured, DIRECTIONAL, DISC, DISC_COLOURED, Directional, Disc, ENVIRONMENT,
    Environment, ExactProbe, FUNCTIONS, Function, FunctionKind, HOSTS, PATH, Paths, RECTANGLE,
    RECTANGLE_COLOURED, Rectangle, SOFT_DISC, SPREAD, SoftDisc, Spread, StatedError,
    define_surroundings, functions_of, mirrored, probes_of, skies, widened,
};
pub use judge::{MAX_PHASE_ERROR, is_whole_light};
pub use pattern::Pattern;
pub use prefilter::{GRID_ERROR, NODE_ERROR, grid_error, node_level};
pub use tolerance::{
    ACROSS, CENTRED, MAX_PROBE_ERROR, Part, Tolerance, light_tolerance, probe_error,
    probe_tolerances, tolerance_under,
};
pub use twin::{Twin, mesh};
