//! A moment of a run, drawn: who is where, what the light reaches, what the eye sees.

use super::camera::Camera;
use super::picture::Picture;
use super::raster::{Buffers, Corner};
use super::shade::{self, CRACK};
use super::track::{Actor, Track};
use cullet_geometry::{Pose, Vec3};

/// Samples along each side of a pixel of the picture.
const SAMPLES: usize = 2;
/// Pixels along each side of the light's own picture of the scene.
const SHADOW_SIZE: usize = 1024;
/// Half side of what the light sees, in reaches of the action.
const SHADOW_REACH: f64 = 2.2;
/// Nothing nearer to the eye than this share of the action's size is drawn.
const NEAREST: f64 = 0.01;

/// The key light and what stands in its way.
pub(super) struct Light {
    /// Unit direction towards the light.
    pub(super) towards: Vec3,
    right: Vec3,
    above: Vec3,
    target: Vec3,
    half: f64,
    seen: Buffers,
}

/// All that stays the same while a moment is drawn, and what of it depends on the moment.
pub(super) struct Stage<'a> {
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
    /// How far a surface darkens its neighbours \[m\].
    pub(super) contact: f64,
    pub(super) focal: f64,
    eye_axes: [Vec3; 3],
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

impl Light {
    fn new(towards: Vec3, up: Vec3, target: Vec3, half: f64) -> Self {
        let right = towards.cross(&up).try_normalize(1e-9).unwrap_or_else(Vec3::x);
        let seen = Buffers::depth(SHADOW_SIZE, SHADOW_SIZE);
        Self { towards, right, above: towards.cross(&right), target, half, seen }
    }

    /// A point in the light's picture; `near` is the way towards the light \[m\].
    fn project(&self, point: Vec3) -> Corner {
        let d = point - self.target;
        let scale = SHADOW_SIZE as f64 / 2.0 / self.half;
        Corner {
            x: SHADOW_SIZE as f64 / 2.0 + d.dot(&self.right) * scale,
            y: SHADOW_SIZE as f64 / 2.0 - d.dot(&self.above) * scale,
            near: d.dot(&self.towards),
        }
    }

    /// Share of the light that reaches a point with that normal \[1\].
    pub(super) fn reaches(&self, point: Vec3, normal: Vec3, (x, y): (usize, usize)) -> f32 {
        let texel = 2.0 * self.half / SHADOW_SIZE as f64;
        let at = self.project(point + normal * (1.6 * texel));
        let mut lit = 0;
        for (dx, dy) in TAPS {
            let (dx, dy) = shade::turned(dx, dy, x, y);
            let (x, y) = ((at.x + f64::from(dx)).floor(), (at.y + f64::from(dy)).floor());
            let inside = x >= 0.0 && y >= 0.0 && x < SHADOW_SIZE as f64 && y < SHADOW_SIZE as f64;
            let open = !inside || {
                let near = self.seen.near[y as usize * SHADOW_SIZE + x as usize];
                f64::from(near) <= at.near + 0.6 * texel
            };
            lit += u8::from(open);
        }
        f32::from(lit) / TAPS.len() as f32
    }
}

/// Where the light's picture is asked, in its pixels: a small disc.
const TAPS: [(f32, f32); 4] = [(0.5, 0.3), (-1.3, 0.9), (0.7, -2.0), (2.3, 1.4)];

impl<'a> Stage<'a> {
    fn set(track: &'a Track, focus: &Focus, camera: &Camera) -> Self {
        let up = track.up;
        let towards = up * 1.0 - camera.right * 0.55 - camera.forward * 0.5;
        let towards = towards.try_normalize(1e-9).unwrap_or(up);
        let level = |axis: Vec3| axis - up * axis.dot(&up);
        let u = level(camera.right).try_normalize(1e-9).unwrap_or_else(Vec3::x);
        Self {
            track,
            up,
            light: Light::new(towards, up, focus.target, SHADOW_REACH * focus.reach),
            floor: focus.floor,
            floor_axes: tile_axes(up, u),
            tile: tile(focus.reach),
            reach: focus.reach,
            contact: 0.12 * focus.reach,
            focal: camera.focal,
            eye_axes: [camera.right, camera.above, camera.forward],
        }
    }

    /// A direction in the axes of the eye.
    pub(super) fn to_eye(&self, n: [f32; 3]) -> [f32; 3] {
        let n = Vec3::from(n.map(f64::from));
        self.eye_axes.map(|axis| n.dot(&axis) as f32)
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

/// Draws one moment.
pub(super) fn draw(track: &Track, focus: &Focus, time: f64, size: (usize, usize)) -> Picture {
    let (width, height) = (size.0 * SAMPLES, size.1 * SAMPLES);
    let camera = focus.camera.scaled(SAMPLES as f64);
    let mut stage = Stage::set(track, focus, &camera);
    let mut seen = Buffers::new(width, height);
    let nearest = NEAREST * focus.reach;
    for (who, actor, pose) in track.present(time) {
        draw_actor(&mut seen, &camera, who, actor, pose, nearest);
        shadow_actor(&mut stage.light, actor, pose);
    }
    let colours = shade::shade(&stage, &camera, &seen);
    Picture::averaged(&colours, size, SAMPLES)
}

fn draw_actor(
    seen: &mut Buffers,
    camera: &Camera,
    who: u32,
    actor: &Actor,
    pose: &Pose,
    nearest: f64,
) {
    let mesh = &actor.mesh;
    let locals: Vec<Vec3> = mesh
        .vertices
        .iter()
        .map(|v| camera.local(pose.transform_point(&(*v).into()).coords))
        .collect();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let corners = triangle.map(|i| locals[i as usize]);
        let who = if mesh.crack[t] { who | CRACK } else { who };
        let normals = || mesh.normals[t].map(|n| pose.rotation * n);
        if corners.iter().all(|c| c.z > nearest) {
            seen.triangle(corners.map(|c| camera.project(c)), who, normals);
        } else {
            clipped(seen, camera, &corners, nearest, who, &normals()[0]);
        }
    }
}

/// A triangle that reaches behind the eye, cut off before it.
fn clipped(
    seen: &mut Buffers,
    camera: &Camera,
    corners: &[Vec3; 3],
    nearest: f64,
    who: u32,
    normal: &Vec3,
) {
    let mut kept: Vec<Vec3> = Vec::with_capacity(4);
    for i in 0..3 {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        if a.z > nearest {
            kept.push(a);
        }
        if (a.z > nearest) != (b.z > nearest) {
            kept.push(a + (b - a) * ((nearest - a.z) / (b.z - a.z)));
        }
    }
    for i in 1..kept.len().saturating_sub(1) {
        let corners = [kept[0], kept[i], kept[i + 1]].map(|c| camera.project(c));
        seen.triangle(corners, who, || [*normal; 3]);
    }
}

fn shadow_actor(light: &mut Light, actor: &Actor, pose: &Pose) {
    let mesh = &actor.mesh;
    let corners: Vec<Corner> = mesh
        .vertices
        .iter()
        .map(|v| light.project(pose.transform_point(&(*v).into()).coords))
        .collect();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| corners[i as usize]);
        light.seen.triangle([a, b, c], 0, || [Vec3::zeros(); 3]);
    }
}
