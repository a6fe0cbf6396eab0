//! A moment of a run, drawn: who is where, what the light reaches, what the eye sees.

use super::around::{Around, turned};
use super::camera::Camera;
use super::change::Changes;
use super::picture::Picture;
use super::raster::{Buffers, Corner};
use super::shade::{CRACK, Changed, Shaded, Shot};
use super::track::{Actor, Track};
use cullet_geometry::{Pose, Vec3};
use std::ops::Range;

/// Samples along each side of a pixel of the picture.
pub(super) const SAMPLES: usize = 2;
/// Pixels along each side of the light's own picture of the scene.
const SHADOW_SIZE: usize = 1024;
/// The same for a still.
const FINE_SHADOW_SIZE: usize = 2048;
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
    /// Pixels along each side of its picture.
    side: usize,
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
    pub(super) around: &'a Around,
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
    fn new(towards: Vec3, up: Vec3, target: Vec3, half: f64, side: usize) -> Self {
        let right = towards.cross(&up).try_normalize(1e-9).unwrap_or_else(Vec3::x);
        let seen = Buffers::depth(side, side);
        Self { towards, right, above: towards.cross(&right), target, half, side, seen }
    }

    /// A point in the light's picture; `near` is the way towards the light \[m\].
    fn project(&self, point: Vec3) -> Corner {
        let d = point - self.target;
        let scale = self.side as f64 / 2.0 / self.half;
        Corner {
            x: self.side as f64 / 2.0 + d.dot(&self.right) * scale,
            y: self.side as f64 / 2.0 - d.dot(&self.above) * scale,
            near: d.dot(&self.towards),
        }
    }

    /// Share of the light that reaches a point with that normal \[1\], and the tile of the light's
    /// picture that decided it, if one did. `turns`: of the disc that is asked, by quarters.
    pub(super) fn reaches(
        &self,
        point: Vec3,
        normal: Vec3,
        turns: Range<usize>,
    ) -> (f32, Option<u32>) {
        let texel = 2.0 * self.half / self.side as f64;
        let at = self.project(point + normal * (1.6 * texel));
        // What leans away from the light must not shade itself where the disc asks beside it.
        let facing = normal.dot(&self.towards).max(0.05);
        let lean = (1.0 - facing * facing).max(0.0).sqrt() / facing;
        let slack = (0.6 + DISC * lean).min(MOST_SLACK) * texel;
        let (size, reach) = (self.side as f64, TAP_REACH as f64);
        let near = |c: f64| c > -reach && c < size + reach;
        if !(near(at.x) && near(at.y)) {
            return (1.0, None);
        }
        let open = |(dx, dy): (f64, f64)| {
            let (x, y) = (at.x + dx, at.y + dy);
            let inside = x >= 0.0 && y >= 0.0 && x < size && y < size;
            !inside || {
                let near = self.seen.near[y as usize * self.side + x as usize];
                f64::from(near) <= at.near + slack
            }
        };
        let lit = |ring: &[[(f64, f64); 2]]| {
            let mut lit = 0;
            for &[one, two] in ring {
                lit += u16::from(open(one)) + u16::from(open(two));
            }
            lit
        };
        let outer = lit(&OUTER[turns.clone()]);
        let count = 2 * turns.len() as u16;
        // Where a whole ring is of one mind, what lies inside it is too.
        let agreed = turns.len() > 1 && (outer == 0 || outer == count);
        let inner = if agreed { outer } else { lit(&INNER[turns]) };
        // A cast takes what is below zero to zero.
        let (x, y) = ((at.x as usize).min(self.side - 1), (at.y as usize).min(self.side - 1));
        let tile = Changes::tile(self.side, x, y) as u32;
        (f32::from(outer + inner) / f32::from(2 * count), Some(tile))
    }
}

/// Where the light's picture is asked, in its pixels: a small disc, in its four turns.
const INNER: [[(f64, f64); 2]; 4] = in_turns([(0.5, 0.3), (-1.3, 0.9)]);
const OUTER: [[(f64, f64); 2]; 4] = in_turns([(0.7, -2.0), (2.3, 1.4)]);

const fn in_turns(taps: [(f32, f32); 2]) -> [[(f64, f64); 2]; 4] {
    let mut all = [[(0.0, 0.0); 2]; 4];
    let mut k = 0;
    while k < 8 {
        let (dx, dy) = turned(taps[k % 2].0, taps[k % 2].1, k / 2);
        all[k / 2][k % 2] = (dx as f64, dy as f64);
        k += 1;
    }
    all
}

/// Radius of the disc \[pixels\].
const DISC: f64 = 2.4;
/// How far what casts a shadow must be before a surface at most, in the light's pixels.
const MOST_SLACK: f64 = 10.0;

/// How far that is from the middle, at most \[pixels\].
pub(super) const TAP_REACH: usize = 3;

impl<'a> Stage<'a> {
    fn set(
        track: &'a Track,
        focus: &Focus,
        camera: &Camera,
        around: &'a Around,
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
            contact: 0.12 * focus.reach,
            focal: camera.focal,
            around,
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

/// Draws moments of a run, one after another. Of the last one it keeps what did not change; what
/// is drawn does not depend on that.
pub(super) struct Reel<'a> {
    track: &'a Track,
    focus: &'a Focus,
    size: (usize, usize),
    around: Around,
    /// Pixels along each side of the light's picture.
    shadow: usize,
    last: Option<Moment>,
}

/// A moment as it was drawn.
struct Moment {
    seen: Buffers,
    light: Buffers,
    shaded: Shaded,
}

impl<'a> Reel<'a> {
    pub(super) fn new(track: &'a Track, focus: &'a Focus, size: (usize, usize)) -> Self {
        let shadow = SHADOW_SIZE;
        Self { track, focus, size, around: Around::default(), shadow, last: None }
    }

    /// For one large picture: with finer shadows.
    pub(super) fn fine(track: &'a Track, focus: &'a Focus, size: (usize, usize)) -> Self {
        Self { shadow: FINE_SHADOW_SIZE, ..Self::new(track, focus, size) }
    }

    /// Draws one moment.
    pub(super) fn draw(&mut self, time: f64) -> Picture {
        let last = self.last.take();
        let (stage, camera, seen) = self.set(time);
        let (mut shaded, changed) = match last {
            None => (Shaded::nothing(self.size), None),
            Some(last) => {
                let (old, new) = ((&last.seen, &last.light), (&seen, &stage.light.seen));
                let changed = Changed::between(old, new);
                (last.shaded, Some(changed))
            }
        };
        shaded.shade(&Shot { stage: &stage, camera: &camera, seen: &seen }, changed.as_ref());
        let picture = shaded.picture.clone();
        let light = stage.light.seen;
        self.last = Some(Moment { seen, light, shaded });
        picture
    }

    /// Puts everything where it is at that time, before the eye and before the light.
    fn set(&self, time: f64) -> (Stage<'_>, Camera, Buffers) {
        let camera = self.focus.camera.scaled(SAMPLES as f64);
        let mut stage = Stage::set(self.track, self.focus, &camera, &self.around, self.shadow);
        let mut seen = Buffers::new(self.size.0 * SAMPLES, self.size.1 * SAMPLES);
        let nearest = NEAREST * self.focus.reach;
        for (who, actor, pose) in self.track.present(time) {
            draw_actor(&mut seen, &camera, who, actor, pose, nearest);
            shadow_actor(&mut stage.light, actor, pose);
        }
        (stage, camera, seen)
    }

    /// The moment with every sample shaded for itself.
    #[cfg(test)]
    pub(super) fn slow(&self, time: f64) -> Picture {
        let (stage, camera, seen) = self.set(time);
        super::shade::slow(&Shot { stage: &stage, camera: &camera, seen: &seen }, self.size)
    }
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
    let locals: Vec<Vec3> = placed(actor, pose).map(|v| camera.local(v)).collect();
    let corners: Vec<Corner> = locals.iter().map(|local| camera.project(*local)).collect();
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        let who = if mesh.crack[t] { who | CRACK } else { who };
        let normals = || mesh.normals[t].map(|n| pose.rotation * n);
        let [a, b, c] = [a as usize, b as usize, c as usize];
        if locals[a].z > nearest && locals[b].z > nearest && locals[c].z > nearest {
            seen.triangle([corners[a], corners[b], corners[c]], who, normals);
        } else {
            let corners = [locals[a], locals[b], locals[c]];
            clipped(seen, camera, &corners, nearest, who, &normals()[0]);
        }
    }
}

/// An actor's corners in the world.
fn placed<'a>(actor: &'a Actor, pose: &Pose) -> impl Iterator<Item = Vec3> + 'a {
    let (turn, way) = (pose.rotation.to_rotation_matrix(), pose.translation.vector);
    actor.mesh.vertices.iter().map(move |v| turn * v + way)
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
    let corners: Vec<Corner> = placed(actor, pose).map(|v| light.project(v)).collect();
    for &[a, b, c] in &actor.mesh.triangles {
        let corners = [corners[a as usize], corners[b as usize], corners[c as usize]];
        light.seen.triangle(corners, 0, || [Vec3::zeros(); 3]);
    }
}
