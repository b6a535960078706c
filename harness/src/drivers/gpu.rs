//! Runs shaders on a driver without a window: wgpu on Vulkan or GL draws a full-screen triangle into an f32 target, and the
//! pixels are read back.
//!
//! A graphics card is not needed: the package `mesa-vulkan-drivers` contains lavapipe (Vulkan), `libegl1 libgles2 libgl1-mesa-dri`
//! contain llvmpipe (GL).
//!
//! Conventions, the same on every backend:
//!
//! * Pixels come row by row from the top: row 0 is next to y = +1 of normalised device coordinates, column 0 next to x = -1.
//! * All bindings are in group 0. Textures are read by `textureLoad` and bound as not filterable, except those with a sampler.
//! * Every failure is an [`Error`](diffraction_shaders::error::Error): what wgpu reports, a lost device, and a panic inside wgpu, by which
//!   wgpu reports some errors (Rust's hook prints the panic's message on stderr, too).
//! * Shaders run with wgpu's run-time checks (bounds of loads, bounded loops). Without them they would be 1.0 to 1.5 times as
//!   fast, but that needs an unsafe call which guarantees that the shader is right, and this runner tests whether shaders are.
//!
//! Calls on one [`Gpu`] and its pipelines, from any number of threads, take turns.

mod adapter;
mod backend;
mod guard;
mod mesh;
mod program;
mod readback;
mod render;
mod spirv;
mod time;

pub use self::adapter::MESA_FLOAT_TARGETS;
pub use self::backend::{AdapterInfo, Backend};
pub use self::mesh::{
    Colours, MeshBuffers, MeshPass, MeshPipeline, MeshProgram, Targets, VERTEX_NUMBERS,
};
pub use self::program::{Program, Shader, Texture, TextureFormat, TextureLayout, Uniform};
pub use self::render::Pipeline;
pub use self::time::FrameTimes;

use std::sync::Arc;

use self::guard::Shared;
use diffraction_shaders::error::Result;
use diffraction_shaders::variant::mesh::Vertex;

/// An open device of one adapter.
#[derive(Clone, Debug)]
pub struct Gpu {
    shared: Arc<Shared>,
}

impl Gpu {
    /// Opens the best adapter of `backend`: graphics cards before software drivers. If `adapter` is given, the first one whose name
    /// or driver contains it, ignoring case.
    ///
    /// The device gets all limits of the adapter, since tables can be large. If no adapter matches, the error lists all adapters of
    /// the machine; if the adapter cannot render to f32, it states what to set.
    pub fn open(backend: Backend, adapter: Option<&str>) -> Result<Gpu> {
        guard::caught(backend.name(), || adapter::open(backend, adapter))
            .map(|shared| Gpu { shared: Arc::new(shared) })
    }

    /// All adapters of the machine, by backend. Empty without a driver.
    pub fn adapters() -> Vec<AdapterInfo> {
        guard::caught("adapters", || Ok(adapter::list())).unwrap_or_default()
    }

    /// The adapters of one backend.
    pub fn adapters_of(backend: Backend) -> Vec<AdapterInfo> {
        guard::caught("adapters", || Ok(adapter::list_of(backend))).unwrap_or_default()
    }

    /// The adapter that was opened.
    pub fn info(&self) -> &AdapterInfo {
        &self.shared.info
    }

    /// Uploads the textures of `program` and compiles its shader.
    ///
    /// A program above a limit of the adapter is refused before anything is created. The error names the limit.
    pub fn program(&self, program: &Program<'_>) -> Result<Pipeline> {
        program::check(program, &self.shared)?;
        self.shared.guarded(program.name, || program::build(&self.shared, program))
    }

    /// Uploads a mesh; triangles are drawn in the order given.
    pub fn mesh(&self, vertices: &[Vertex], triangles: &[[u32; 3]]) -> Result<MeshBuffers> {
        self.shared.guarded("mesh", || Ok(mesh::buffers(&self.shared, vertices, triangles)))
    }

    /// Compiles one pass over a mesh and uploads its textures.
    pub fn mesh_program(
        &self,
        program: &MeshProgram<'_>,
        targets: Targets,
    ) -> Result<MeshPipeline> {
        self.shared.guarded(program.name, || mesh::build(&self.shared, program, targets))
    }

    /// Draws a mesh. Returns pictures as `[picture][row][column]`, top row first; alpha is 0 outside the mesh.
    pub fn draw_mesh(
        &self,
        name: &str,
        mesh: &MeshBuffers,
        pass: MeshPass<'_>,
        targets: Targets,
        size: [u32; 2],
    ) -> Result<Vec<Vec<[f32; 4]>>> {
        self.shared.guarded(name, || mesh::draw(&self.shared, name, mesh, pass, targets, size))
    }
}

#[cfg(test)]
mod tests {
    use naga::ShaderStage;

    use super::*;

    #[test]
    fn a_lost_device_is_an_error_and_stays_one() {
        for backend in [Backend::Vulkan, Backend::Gl] {
            // tests decide whether a driver is required
            let Ok(gpu) = Gpu::open(backend, None) else { continue };
            let wgsl = "
                @vertex fn v(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
                    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
                }
                @fragment fn f() -> @location(0) vec4f { return vec4f(1.0); }";
            let [vertex, fragment] = [("v", ShaderStage::Vertex), ("f", ShaderStage::Fragment)]
                .map(|(entry, stage)| spirv_of(wgsl, entry, stage));
            let with = |shader| Program {
                name: "test",
                shader,
                vertex_entry: "v",
                fragment_entry: "f",
                textures: vec![],
                uniform: None,
            };
            let wgsl = with(Shader::Wgsl(wgsl));
            let spirv = with(Shader::Spirv { vertex: &vertex, fragment: &fragment });
            // only Vulkan takes unchanged SPIR-V
            let programs = if backend == Backend::Vulkan { vec![wgsl, spirv] } else { vec![wgsl] };
            let pipelines: Vec<Pipeline> =
                programs.iter().map(|program| gpu.program(program).expect("valid")).collect();
            for pipeline in &pipelines {
                assert_eq!(pipeline.render(1, 1, &[]).expect("renders"), [[1.0; 4]]);
            }
            gpu.shared.device.destroy();
            for (program, pipeline) in programs.iter().zip(&pipelines).cycle().take(4) {
                for error in [
                    pipeline.render(1, 1, &[]).expect_err("lost"),
                    pipeline.time(2, 2, &[]).expect_err("lost"),
                    gpu.program(program).expect_err("lost"),
                ] {
                    assert!(error.to_string().contains("was lost"), "{error}");
                }
            }
            assert!(Gpu::open(backend, None).and_then(|gpu| gpu.program(&programs[0])).is_ok());
        }
    }

    fn spirv_of(wgsl: &str, entry: &str, stage: ShaderStage) -> Vec<u32> {
        use naga::valid::{Capabilities, ValidationFlags, Validator};
        let module = naga::front::wgsl::parse_str(wgsl).expect("parses");
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        let info = validator.validate(&module).expect("valid");
        let options =
            naga::back::spv::PipelineOptions { shader_stage: stage, entry_point: entry.to_owned() };
        naga::back::spv::write_vec(&module, &info, &Default::default(), Some(&options))
            .expect("writes")
    }
}
