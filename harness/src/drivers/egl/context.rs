//! All calls into C: displays and surfaceless contexts of EGL, and the functions of GL.
//!
//! A value of [`Current`] proves that a context is current on this thread; all functions of GL are its methods. GL objects are
//! not deleted one by one: they are freed with their context.
#![expect(unsafe_code, reason = "EGL and GL are C interfaces")]

use std::ffi::{CStr, c_void};
use std::marker::PhantomData;
use std::ptr;
use std::sync::OnceLock;

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::tables::{Table, TexelFormat};
use glow::{HasContext, PixelPackData, PixelUnpackData};
use khronos_egl as egl;

use super::{Dialect, REMEDY};

pub(super) type Instance = egl::DynamicInstance<egl::EGL1_5>;

/// EGL_EXT_platform_device, EGL_MESA_platform_surfaceless.
const PLATFORM_DEVICE: egl::Enum = 0x313F;
const PLATFORM_SURFACELESS: egl::Enum = 0x31DD;

/// The EGL library. It stays loaded, since drivers have threads that outlive a context.
pub(super) fn instance() -> Result<&'static Instance> {
    static INSTANCE: OnceLock<Instance> = OnceLock::new();
    if let Some(instance) = INSTANCE.get() {
        return Ok(instance);
    }
    // SAFETY: the system's EGL library may be loaded at any time, and its functions have the types of the standard.
    let loaded = unsafe { Instance::load_required_from_filename("libEGL.so.1") }
        .map_err(|e| Error::new("EGL", e).remedy(REMEDY))?;
    Ok(INSTANCE.get_or_init(|| loaded))
}

/// The displays that need no window: one for each device, then Mesa's surfaceless display, then the default.
///
/// Devices come first because wgpu opens the surfaceless display and later closes it for all its users.
pub(super) fn displays(egl: &Instance) -> Vec<egl::Display> {
    let extensions = egl.query_string(None, egl::EXTENSIONS).map(CStr::to_string_lossy);
    let extensions = extensions.unwrap_or_default();
    let has = |name: &str| extensions.split(' ').any(|word| word == name);
    let mut native = Vec::new();
    if has("EGL_EXT_platform_device") {
        native.extend(devices(egl).into_iter().map(|device| (PLATFORM_DEVICE, device)));
    }
    if has("EGL_MESA_platform_surfaceless") {
        native.push((PLATFORM_SURFACELESS, ptr::null_mut()));
    }
    let platform = |(platform, native): (egl::Enum, *mut c_void)| {
        // SAFETY: the pointer is a device that EGL listed, or null for a platform without devices, as its extension demands.
        unsafe { egl.get_platform_display(platform, native, &[egl::ATTRIB_NONE]) }.ok()
    };
    let mut found: Vec<_> = native.into_iter().filter_map(platform).collect();
    // SAFETY: the default display takes no pointer.
    found.extend(unsafe { egl.get_display(egl::DEFAULT_DISPLAY) });
    found
}

/// The devices by EGL_EXT_device_enumeration; empty without that extension.
fn devices(egl: &Instance) -> Vec<*mut c_void> {
    type Query =
        unsafe extern "system" fn(egl::Int, *mut *mut c_void, *mut egl::Int) -> egl::Boolean;
    let Some(query) = egl.get_proc_address("eglQueryDevicesEXT") else { return Vec::new() };
    let mut devices = [ptr::null_mut(); 32];
    let mut count = 0;
    // SAFETY: the extension gives the function this type; it writes at most 32 devices and their number.
    let found = unsafe {
        let query = std::mem::transmute::<extern "system" fn(), Query>(query);
        query(32, devices.as_mut_ptr(), &mut count)
    };
    let count = if found == egl::TRUE { usize::try_from(count).unwrap_or(0) } else { 0 };
    devices.into_iter().take(count).collect()
}

/// A context, destroyed with all its objects when dropped.
pub(super) struct Context {
    egl: &'static Instance,
    display: egl::Display,
    api: egl::Enum,
    context: egl::Context,
    gl: OnceLock<glow::Context>,
}

impl Context {
    /// Makes a context on an open display.
    pub(super) fn new(
        dialect: Dialect,
        display: egl::Display,
        config: egl::Config,
    ) -> Result<Context> {
        let egl = instance()?;
        let (api, [major, minor], profile) = match dialect {
            Dialect::Glsl450 => {
                let core = [egl::CONTEXT_OPENGL_PROFILE_MASK, egl::CONTEXT_OPENGL_CORE_PROFILE_BIT];
                (egl::OPENGL_API, [4, 5], Some(core))
            }
            Dialect::GlslEs300 => (egl::OPENGL_ES_API, [3, 0], None),
        };
        let mut attributes =
            vec![egl::CONTEXT_MAJOR_VERSION, major, egl::CONTEXT_MINOR_VERSION, minor];
        attributes.extend(profile.into_iter().flatten());
        attributes.push(egl::NONE);
        let made =
            egl.bind_api(api).and_then(|()| egl.create_context(display, config, None, &attributes));
        let context = made.map_err(|e| {
            Error::new(dialect, format!("no context of version {major}.{minor}: EGL says {e:?}"))
        })?;
        Ok(Context { egl, display, api, context, gl: OnceLock::new() })
    }

    /// Makes the context current on this thread for the lifetime of the returned value. Errors are about `subject`.
    pub(super) fn current<'a>(&'a self, subject: &'a str) -> Result<Current<'a>> {
        let Context { egl, display, api, context, .. } = self;
        let made = egl
            .bind_api(*api)
            .and_then(|()| egl.make_current(*display, None, None, Some(*context)));
        made.map_err(|e| {
            Error::new(subject, format!("the context cannot be made current: EGL says {e:?}"))
        })?;
        let gl = self.gl.get_or_init(|| {
            let load = |name: &str| match egl.get_proc_address(name) {
                Some(function) => function as *const c_void,
                None => ptr::null(),
            };
            // SAFETY: the context is current, and EGL gives the functions of GL by their names.
            unsafe { glow::Context::from_loader_function(load) }
        });
        Ok(Current { context: self, gl, subject, of_one_thread: PhantomData })
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // nothing can be done about a failure; the end of the process frees everything
        let _ = self.egl.destroy_context(self.display, self.context);
    }
}

/// A context that is current on this thread.
pub(super) struct Current<'a> {
    context: &'a Context,
    gl: &'a glow::Context,
    subject: &'a str,
    of_one_thread: PhantomData<*const ()>,
}

impl Drop for Current<'_> {
    fn drop(&mut self) {
        let Context { egl, display, api, .. } = self.context;
        let _ = egl.bind_api(*api).and_then(|()| egl.make_current(*display, None, None, None));
    }
}

// In the following methods, `self` proves that the context is current. Names of objects of other contexts are errors of GL,
// not undefined behaviour.
impl Current<'_> {
    /// An error about the subject.
    pub(super) fn fail<T>(&self, cause: impl std::fmt::Display) -> Result<T> {
        Err(Error::new(self.subject, cause))
    }

    /// Returns an error if GL recorded one since the last call.
    pub(super) fn check(&self, what: &str) -> Result<()> {
        // SAFETY: the context is current.
        match unsafe { self.gl.get_error() } {
            glow::NO_ERROR => Ok(()),
            glow::INVALID_ENUM => self.fail(format!("{what}: GL_INVALID_ENUM")),
            glow::INVALID_VALUE => self.fail(format!("{what}: GL_INVALID_VALUE")),
            glow::INVALID_OPERATION => self.fail(format!("{what}: GL_INVALID_OPERATION")),
            glow::OUT_OF_MEMORY => self.fail(format!("{what}: the driver has no memory left")),
            other => self.fail(format!("{what}: GL error 0x{other:04X}")),
        }
    }

    /// Renderer and version.
    pub(super) fn driver(&self) -> String {
        let [renderer, version] = [glow::RENDERER, glow::VERSION].map(|name| {
            // SAFETY: the context is current; every version has both strings.
            unsafe { self.gl.get_parameter_string(name) }
        });
        format!("{renderer}, {version}")
    }

    pub(super) fn version(&self) -> (u32, u32) {
        let version = self.gl.version();
        (version.major, version.minor)
    }

    pub(super) fn has(&self, extension: &str) -> bool {
        self.gl.supported_extensions().contains(extension)
    }

    /// A limit of the driver, a single number.
    pub(super) fn limit(&self, parameter: u32) -> i32 {
        // SAFETY: the context is current; the parameters asked for are single numbers of every version.
        unsafe { self.gl.get_parameter_i32(parameter) }
    }

    /// A compiled shader, or the driver's log.
    pub(super) fn shader(&self, kind: u32, text: &str) -> Result<glow::Shader, String> {
        // SAFETY: the context is current; the text is passed with its length.
        unsafe {
            let shader = self.gl.create_shader(kind)?;
            self.gl.shader_source(shader, text);
            self.gl.compile_shader(shader);
            match self.gl.get_shader_compile_status(shader) {
                true => Ok(shader),
                false => Err(self.gl.get_shader_info_log(shader)),
            }
        }
    }

    /// Links a program and uses it from now on; the error is the driver's log.
    pub(super) fn program(&self, shaders: [glow::Shader; 2]) -> Result<glow::Program, String> {
        // SAFETY: the context is current.
        unsafe {
            let program = self.gl.create_program()?;
            shaders.into_iter().for_each(|shader| self.gl.attach_shader(program, shader));
            self.gl.link_program(program);
            if !self.gl.get_program_link_status(program) {
                return Err(self.gl.get_program_info_log(program));
            }
            self.gl.use_program(Some(program));
            // the vertex stage reads no attributes, but a core context wants an array of them
            self.gl.bind_vertex_array(Some(self.gl.create_vertex_array()?));
            Ok(program)
        }
    }

    /// Whether the program in use has a texture of that name. Sets its `unit`, if the shader does not.
    pub(super) fn texture_unit(
        &self,
        program: glow::Program,
        name: &str,
        unit: Option<u32>,
    ) -> bool {
        // SAFETY: the context is current.
        unsafe {
            let place = self.gl.get_uniform_location(program, name);
            if let Some(unit) = unit {
                self.gl.uniform_1_i32(place.as_ref(), unit as i32);
            }
            place.is_some()
        }
    }

    /// Size in bytes of the uniform block of that name, if there is one. Sets its binding `point`, if the shader does not.
    pub(super) fn block(
        &self,
        program: glow::Program,
        name: &str,
        point: Option<u32>,
    ) -> Option<i32> {
        // SAFETY: the context is current.
        unsafe {
            let block = self.gl.get_uniform_block_index(program, name)?;
            if let Some(point) = point {
                self.gl.uniform_block_binding(program, block, point);
            }
            let size = glow::UNIFORM_BLOCK_DATA_SIZE;
            Some(self.gl.get_active_uniform_block_parameter_i32(program, block, size))
        }
    }

    /// Makes the buffer of a uniform block. [`Current::rows`] fills the buffer made last.
    pub(super) fn uniform_buffer(&self, point: u32, bytes: i32) -> Result<(), String> {
        // SAFETY: the context is current; GL allocates the bytes.
        unsafe {
            let buffer = self.gl.create_buffer()?;
            self.gl.bind_buffer_base(glow::UNIFORM_BUFFER, point, Some(buffer));
            self.gl.buffer_data_size(glow::UNIFORM_BUFFER, bytes, glow::DYNAMIC_DRAW);
        }
        Ok(())
    }

    /// Makes a texture, filtered if its table is, and binds it to a unit.
    pub(super) fn upload(
        &self,
        unit: u32,
        table: &Table,
        [width, height, layers]: [i32; 3],
    ) -> Result<(), String> {
        let (internal, format, channels) = match table.format {
            TexelFormat::Rg16Float => (glow::RG16F as i32, glow::RG, 2),
            TexelFormat::Rgba16Float => (glow::RGBA16F as i32, glow::RGBA, 4),
            TexelFormat::Rg32Float => (glow::RG32F as i32, glow::RG, 2),
            TexelFormat::Rgba32Float => (glow::RGBA32F as i32, glow::RGBA, 4),
            TexelFormat::Rgb9e5Ufloat => (glow::RGB9_E5 as i32, glow::RGB, 3),
        };
        // rounded to the texel format here, so that the driver does not round
        let texels: Vec<f32> = table.clone().rounded().texels.iter().map(|&v| v as f32).collect();
        let sides = [width, height, layers, channels].map(|n| usize::try_from(n).unwrap_or(0));
        if sides.into_iter().try_fold(1, usize::checked_mul) != Some(texels.len()) {
            return Err(format!("has a wrong number of texels: {} numbers", texels.len()));
        }
        let data = PixelUnpackData::Slice(Some(bytemuck::cast_slice(&texels)));
        let flat = table.layers == 0;
        let to = if flat { glow::TEXTURE_2D } else { glow::TEXTURE_2D_ARRAY };
        let filter = if table.filtered { glow::LINEAR } else { glow::NEAREST } as i32;
        let edge = glow::CLAMP_TO_EDGE as i32;
        // SAFETY: the context is current; GL reads `width · height · layers · channels` floats, which were counted above: no
        // buffer is bound for unpacking, and rows of floats need no padding.
        unsafe {
            let texture = self.gl.create_texture()?;
            self.gl.active_texture(glow::TEXTURE0 + unit);
            self.gl.bind_texture(to, Some(texture));
            self.gl.tex_parameter_i32(to, glow::TEXTURE_MIN_FILTER, filter);
            self.gl.tex_parameter_i32(to, glow::TEXTURE_MAG_FILTER, filter);
            self.gl.tex_parameter_i32(to, glow::TEXTURE_WRAP_S, edge);
            self.gl.tex_parameter_i32(to, glow::TEXTURE_WRAP_T, edge);
            self.gl.tex_parameter_i32(to, glow::TEXTURE_MAX_LEVEL, 0);
            let float = glow::FLOAT;
            if flat {
                self.gl.tex_image_2d(to, 0, internal, width, height, 0, format, float, data);
            } else {
                self.gl
                    .tex_image_3d(to, 0, internal, width, height, layers, 0, format, float, data);
            }
        }
        Ok(())
    }

    /// Makes a new picture of 32-bit floats the target of all further draws. Returns whether the driver supports this.
    pub(super) fn target(&self, [width, height]: [i32; 2]) -> Result<bool, String> {
        let (frame, buffer) = (glow::FRAMEBUFFER, glow::RENDERBUFFER);
        // SAFETY: the context is current; a previous picture, if any, is no longer read.
        unsafe {
            // the previous picture, if any
            if let Some(old) = self.gl.get_parameter_renderbuffer(glow::RENDERBUFFER_BINDING) {
                self.gl.delete_renderbuffer(old);
            }
            if let Some(old) = self.gl.get_parameter_framebuffer(glow::DRAW_FRAMEBUFFER_BINDING) {
                self.gl.delete_framebuffer(old);
            }
            let picture = self.gl.create_renderbuffer()?;
            self.gl.bind_renderbuffer(buffer, Some(picture));
            self.gl.renderbuffer_storage(buffer, glow::RGBA32F, width, height);
            self.gl.bind_framebuffer(frame, Some(self.gl.create_framebuffer()?));
            self.gl.framebuffer_renderbuffer(frame, glow::COLOR_ATTACHMENT0, buffer, Some(picture));
            self.gl.viewport(0, 0, width, height);
            self.gl.enable(glow::SCISSOR_TEST);
            Ok(self.gl.check_framebuffer_status(frame) == glow::FRAMEBUFFER_COMPLETE)
        }
    }

    /// Draws `rows` rows, starting at row `bottom`, and reads them back, lowest row first.
    pub(super) fn rows(&self, [width, bottom, rows]: [i32; 3], uniforms: &[u8]) -> Vec<[f32; 4]> {
        let sides = [width, rows].map(|n| usize::try_from(n).unwrap_or(0));
        let mut pixels = vec![[0.0_f32; 4]; sides[0] * sides[1]];
        let data = PixelPackData::Slice(Some(bytemuck::cast_slice_mut(&mut pixels)));
        let uniform = glow::UNIFORM_BUFFER;
        let (format, float) = (glow::RGBA, glow::FLOAT);
        // SAFETY: the context is current; GL writes `width · rows` pixels of four floats: no buffer is bound for packing, and
        // rows of floats need no padding.
        unsafe {
            self.gl.buffer_sub_data_u8_slice(uniform, 0, uniforms);
            self.gl.scissor(0, bottom, width, rows);
            self.gl.clear(glow::COLOR_BUFFER_BIT);
            self.gl.draw_arrays(glow::TRIANGLES, 0, 3);
            self.gl.read_pixels(0, bottom, width, rows, format, float, data);
        }
        pixels
    }
}
