//! The limits that each graphics API guarantees, in one table for lints, manifests and listings.

use std::collections::BTreeSet;
use std::fmt::{Display, Formatter};

use serde::{Deserialize, Serialize};

/// A graphics API, by its guaranteed limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// WebGL 2.0, which inherits the minima of OpenGL ES 3.0.
    Webgl2,
    /// WebGPU with default limits.
    Webgpu,
    /// Vulkan 1.0 with required limits.
    Vulkan,
}

impl Profile {
    /// All profiles, narrowest first.
    pub const ALL: [Profile; 3] = [Profile::Webgl2, Profile::Webgpu, Profile::Vulkan];

    /// The profile's name in manifests and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Profile::Webgl2 => "webgl2",
            Profile::Webgpu => "webgpu",
            Profile::Vulkan => "vulkan",
        }
    }

    /// The limits that every implementation of the API supports.
    pub fn limits(self) -> Limits {
        match self {
            // OpenGL ES 3.0.6, section 6.2, minimum values of tables 6.28 (texture sizes, layers),
            // 6.31 (fragment shader: blocks, texture units) and 6.32 (block size).
            Profile::Webgl2 => Limits {
                texture_2d: 2048,       // MAX_TEXTURE_SIZE
                texture_3d: 256,        // MAX_3D_TEXTURE_SIZE
                array_layers: 256,      // MAX_ARRAY_TEXTURE_LAYERS
                textures_per_stage: 16, // MAX_TEXTURE_IMAGE_UNITS
                uniform_block: 16384,   // MAX_UNIFORM_BLOCK_SIZE
                uniform_blocks: 12,     // MAX_FRAGMENT_UNIFORM_BLOCKS
            },
            // WebGPU, section 3.6.2 "Limits", default values.
            Profile::Webgpu => Limits {
                texture_2d: 8192,       // maxTextureDimension2D
                texture_3d: 2048,       // maxTextureDimension3D
                array_layers: 256,      // maxTextureArrayLayers
                textures_per_stage: 16, // maxSampledTexturesPerShaderStage
                uniform_block: 65536,   // maxUniformBufferBindingSize
                uniform_blocks: 12,     // maxUniformBuffersPerShaderStage
            },
            // Vulkan 1.0, chapter "Limits", table "Required Limits".
            Profile::Vulkan => Limits {
                texture_2d: 4096,       // maxImageDimension2D
                texture_3d: 256,        // maxImageDimension3D
                array_layers: 256,      // maxImageArrayLayers
                textures_per_stage: 16, // maxPerStageDescriptorSampledImages
                uniform_block: 16384,   // maxUniformBufferRange
                uniform_blocks: 12,     // maxPerStageDescriptorUniformBuffers
            },
        }
    }
}

/// Guaranteed limits; sizes in texels, blocks in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Limits {
    /// Width and height of a 2-D texture or of a layer.
    pub texture_2d: u32,
    /// Each side of a 3-D texture.
    pub texture_3d: u32,
    /// Layers of a 2-D array.
    pub array_layers: u32,
    /// Sampled textures that one shader stage may read.
    pub textures_per_stage: u32,
    /// Bytes of one uniform block.
    pub uniform_block: u32,
    /// Uniform blocks that one shader stage may read.
    pub uniform_blocks: u32,
}

impl Limits {
    /// The limits that all profiles guarantee. Every shader text must respect them.
    pub fn common() -> Limits {
        let [first, rest @ ..] = Profile::ALL.map(Profile::limits);
        rest.iter().fold(first, |a, b| Limits {
            texture_2d: a.texture_2d.min(b.texture_2d),
            texture_3d: a.texture_3d.min(b.texture_3d),
            array_layers: a.array_layers.min(b.array_layers),
            textures_per_stage: a.textures_per_stage.min(b.textures_per_stage),
            uniform_block: a.uniform_block.min(b.uniform_block),
            uniform_blocks: a.uniform_blocks.min(b.uniform_blocks),
        })
    }

    /// Whether every implementation can create a texture of that size.
    pub fn allow(&self, extent: Extent) -> bool {
        match extent {
            Extent::Plane { width, height } => width.max(height) <= self.texture_2d,
            Extent::Layers { width, height, layers } => {
                width.max(height) <= self.texture_2d && layers <= self.array_layers
            }
            Extent::Volume { width, height, depth } => {
                width.max(height).max(depth) <= self.texture_3d
            }
        }
    }
}

/// Dimension and size of a texture, in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Extent {
    /// 2-D.
    Plane {
        /// Texels along u.
        width: u32,
        /// Texels along v.
        height: u32,
    },
    /// 2-D array.
    Layers {
        /// Texels along u.
        width: u32,
        /// Texels along v.
        height: u32,
        /// Number of layers.
        layers: u32,
    },
    /// 3-D.
    Volume {
        /// Texels along u.
        width: u32,
        /// Texels along v.
        height: u32,
        /// Texels along w.
        depth: u32,
    },
}

impl Display for Extent {
    fn fmt(&self, to: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Extent::Plane { width, height } => write!(to, "{width} × {height} texels"),
            Extent::Layers { width, height, layers } => {
                write!(to, "{width} × {height} texels in {layers} layers")
            }
            Extent::Volume { width, height, depth } => {
                write!(to, "{width} × {height} × {depth} texels")
            }
        }
    }
}

/// The profiles in which all these textures can be created.
pub fn fits(textures: &[Extent]) -> BTreeSet<Profile> {
    let all_fit = |profile: &Profile| textures.iter().all(|t| profile.limits().allow(*t));
    Profile::ALL.into_iter().filter(all_fit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(textures: &[Extent]) -> Vec<&'static str> {
        fits(textures).into_iter().map(Profile::name).collect()
    }

    #[test]
    fn each_limit_on_both_sides() {
        let plane = |width, height| Extent::Plane { width, height };
        let layers = |layers| Extent::Layers { width: 100, height: 100, layers };
        let volume = |depth| Extent::Volume { width: 16, height: 16, depth };
        assert_eq!(layers(3).to_string(), "100 × 100 texels in 3 layers");
        assert_eq!(names(&[]), ["webgl2", "webgpu", "vulkan"]);
        assert_eq!(names(&[plane(2048, 2048)]), ["webgl2", "webgpu", "vulkan"]);
        assert_eq!(names(&[plane(1, 2049)]), ["webgpu", "vulkan"]);
        assert_eq!(names(&[plane(4097, 1)]), ["webgpu"]);
        assert!(names(&[plane(8193, 1)]).is_empty());
        assert_eq!(names(&[layers(256)]), ["webgl2", "webgpu", "vulkan"]);
        assert!(names(&[layers(257)]).is_empty());
        assert_eq!(names(&[volume(256)]), ["webgl2", "webgpu", "vulkan"]);
        assert_eq!(names(&[volume(257)]), ["webgpu"]);
        assert!(names(&[volume(257), plane(8193, 1)]).is_empty());
    }

    #[test]
    fn common_limits_are_the_smallest() {
        let common = Limits::common();
        assert_eq!((common.uniform_block, common.textures_per_stage), (16384, 16));
        assert_eq!((common.texture_2d, common.texture_3d, common.array_layers), (2048, 256, 256));
    }
}
