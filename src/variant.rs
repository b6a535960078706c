//! How variants compute: a [`Form`] for every way, with its counts, template constants, tables, cost, tolerances and
//! description; the [`Function`]s that a shader offers; and the [`Twin`], each form's algorithm in f64.

mod bound;
mod computation;
mod cost;
mod forms;
mod functions;
mod lay;
mod prefilter;
mod tolerance;
mod twin;

pub use bound::{
    AUTO_TAIL, AUTO_TAIL_PQ, ErrorBound, ISOLATED, LobeBounds, replica_tail, window_tail,
};
pub use computation::{Computation, Ground};
pub use cost::Cost;
pub use forms::*;
pub use functions::{DIRECTIONAL, Directional, ExactProbe, FUNCTIONS, Function, PROBES};
pub use prefilter::{GRID_ERROR, NODE_ERROR, grid_error, node_level};
pub use tolerance::{ACROSS, CENTRED, Part, Tolerance, probe_tolerances};
pub use twin::{Twin, mesh};
