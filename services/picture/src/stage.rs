//! All that stays the same while a moment is drawn: the eye, the light, the floor.

use super::camera::Camera;
use super::light::Light;
use super::occlusion::{AmbientOcclusion, Viewpoint};
use super::track::Track;
use cullet_geometry::Vec3;

/// Samples along each side of a pixel of the picture.
pub(super) const SAMPLES: usize = 2;
/// Half side of what the light sees, in reaches of the action.
const SHADOW_REACH: f64 = 2.2;
/// How far a surface darkens its neighbours, in reaches of the action.
const CONTACT: f64 = 0.12;

/// All that stays the same while a moment is drawn, and what of it depends on the moment.
pub(super) struct RenderContext<'a> {
    pub(super) track: &'a Track,
    pub(super) up: Vec3,
    pub(super) light: Light,
    /// Height of a floor of our own, in a scene that has none \[m\].
    pub(super) floor: Option<f64>,
    pub(super) floor_axes: (Vec3, Vec3),
    /// Side of a tile of the floor \[m\].
    pub(super) tile: f64,
    /// Size of the action \[m\].
    pub(super) reach: f64,
    pub(super) view: Viewpoint,
    pub(super) occlusion: &'a AmbientOcclusion,
}

/// What is looked at in all pictures of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Focus {
    pub(super) camera: Camera,
    /// Middle of the action \[m\].
    pub(super) target: Vec3,
    /// Half its size \[m\].
    pub(super) reach: f64,
    /// Height of a floor of our own \[m\].
    pub(super) floor: Option<f64>,
}

impl<'a> RenderContext<'a> {
    pub(super) fn set(
        track: &'a Track,
        focus: &Focus,
        camera: &Camera,
        occlusion: &'a AmbientOcclusion,
        shadow: usize,
    ) -> Self {
        let up = track.up;
        let towards = up * 1.0 - camera.right * 0.55 - camera.forward * 0.5;
        let towards = towards.try_normalize(1e-9).unwrap_or(up);
        let level = |axis: Vec3| axis - up * axis.dot(&up);
        let u = level(camera.right).try_normalize(1e-9).unwrap_or_else(Vec3::x);
        Self {
            track,
            up,
            light: Light::new(towards, up, focus.target, SHADOW_REACH * focus.reach, shadow),
            floor: focus.floor,
            floor_axes: tile_axes(up, u),
            tile: tile(focus.reach),
            reach: focus.reach,
            view: Viewpoint::new(camera, CONTACT * focus.reach),
            occlusion,
        }
    }
}

/// Axes of the floor that do not turn with the eye, so that tiles lie along the world's axes.
fn tile_axes(up: Vec3, fallback: Vec3) -> (Vec3, Vec3) {
    let axis = [Vec3::x(), Vec3::y(), Vec3::z()].into_iter().find(|a| a.dot(&up).abs() < 0.5);
    let axis = axis.unwrap_or(fallback);
    let u = (axis - up * axis.dot(&up)).try_normalize(1e-9).unwrap_or(fallback);
    (u, up.cross(&u))
}

/// A round tile size near half the action's \[m\].
fn tile(reach: f64) -> f64 {
    let mut size = 1e-3;
    let mut turn = [2.0, 2.5, 2.0].into_iter().cycle();
    while size < 0.4 * reach {
        size *= turn.next().unwrap_or(2.0);
    }
    size
}
