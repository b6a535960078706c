//! Tangent frames in which the entry points of meshes must give the colours of a probe.

use std::f64::consts::FRAC_PI_2;

use glam::{DMat3, DVec3};

use super::block::Block;

/// A vertex, and where its mesh stands in the world.
pub(super) struct Frame {
    pub normal: DVec3,
    pub tangent: DVec3,
    /// 1 or -1: the bitangent is `hand (normal × tangent)`.
    pub hand: f64,
    /// From the tangent towards the bitangent, in radians.
    pub angle: f64,
    model: DMat3,
}

impl Frame {
    /// The frames in turn: both hands, a turned one, a mirrored mesh. All lie along the axes, so that they round nothing.
    pub(super) fn number(index: usize) -> Frame {
        let turned = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
        let mirrored = DMat3::from_cols(DVec3::Y, -DVec3::Z, DVec3::X);
        let (normal, tangent, hand, angle, model) = match index % 4 {
            0 => (DVec3::Z, DVec3::X, 1.0, 0.0, DMat3::IDENTITY),
            1 => (DVec3::Z, DVec3::X, -1.0, 0.0, DMat3::IDENTITY),
            2 => (DVec3::X, DVec3::Y, 1.0, FRAC_PI_2, turned),
            _ => (DVec3::Y, -DVec3::Z, -1.0, 0.0, mirrored),
        };
        Frame { normal, tangent, hand, angle, model }
    }

    /// A direction of the tangent frame, in the world.
    fn in_world(&self, direction: DVec3) -> DVec3 {
        let across = self.hand * self.normal.cross(self.tangent);
        let (sine, cosine) = self.angle.sin_cos();
        let along = cosine * self.tangent + sine * across;
        let beside = cosine * across - sine * self.tangent;
        self.model * (direction.x * along + direction.y * beside + direction.z * self.normal)
    }

    /// The uniforms of meshes for a vertex at the origin, lit from `wi` and seen from `wr`.
    pub(super) fn uniforms(&self, block: &Block, wi: DVec3, wr: DVec3) -> Vec<f64> {
        let matrix = |m: DMat3| {
            let mut numbers = [0.0; 16];
            for (column, of) in m.to_cols_array_2d().iter().enumerate() {
                numbers[4 * column..4 * column + 3].copy_from_slice(of);
            }
            numbers[15] = 1.0;
            numbers
        };
        let point = |v: DVec3| [v.x, v.y, v.z, 0.0];
        block.floats(&[
            ("model", &matrix(self.model)),
            ("view", &matrix(DMat3::IDENTITY)),
            ("projection", &matrix(DMat3::IDENTITY)),
            ("light_direction", &point(self.in_world(wi))),
            ("eye", &point(self.in_world(wr))),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frames_have_both_hands_and_are_told_apart() {
        let frames: Vec<Frame> = (0..4).map(Frame::number).collect();
        assert_eq!(frames.iter().map(|frame| frame.hand).sum::<f64>(), 0.0);
        assert!(frames.iter().any(|frame| frame.model.determinant() < 0.0));
        let direction = DVec3::new(0.6, 0.0, 0.8);
        for frame in &frames {
            let along = frame.in_world(direction).dot(frame.model * frame.normal);
            assert!((along - 0.8).abs() < 1e-15, "{along}");
            assert!(frame.normal.dot(frame.tangent) == 0.0);
        }
        let beside = |frame: &Frame| frame.in_world(DVec3::Y);
        assert_eq!(beside(&frames[0]), -beside(&frames[1]));
    }
}
