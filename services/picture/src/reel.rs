//! Moments of a run, drawn: who is where, what the light reaches, what the eye sees.

use super::camera::Camera;
use super::light::Light;
use super::occlusion::AmbientOcclusion;
use super::picture::Picture;
use super::raster::{Buffers, ScreenCorner};
#[cfg(test)]
use super::shade::slow;
use super::shade::{CRACK, Changed, Shaded, Shot};
use super::sheets::SheetActor;
use super::stage::{Focus, RenderContext, SAMPLES};
use super::track::{Actor, Track};
use cullet_geometry::{Pose, Vec3};

/// Pixels along each side of the light's own picture of the scene.
const SHADOW_SIZE: usize = 1024;
/// The same for a still.
const FINE_SHADOW_SIZE: usize = 2048;
/// Nothing nearer to the eye than this share of the action's size is drawn.
const NEAREST: f64 = 0.01;

/// Draws moments of a run, one after another. Of the last one it keeps what did not change; what
/// is drawn does not depend on that.
pub(super) struct Reel<'a> {
    track: &'a Track,
    focus: &'a Focus,
    size: (usize, usize),
    occlusion: AmbientOcclusion,
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
        Self { track, focus, size, occlusion: AmbientOcclusion::default(), shadow, last: None }
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
    fn set(&self, time: f64) -> (RenderContext<'_>, Camera, Buffers) {
        let camera = self.focus.camera.scaled(SAMPLES as f64);
        let mut stage =
            RenderContext::set(self.track, self.focus, &camera, &self.occlusion, self.shadow);
        let tinted = self.track.sheets.iter().any(SheetActor::is_tinted);
        let buffers = if tinted { Buffers::tinted } else { Buffers::new };
        let mut seen = buffers(self.size.0 * SAMPLES, self.size.1 * SAMPLES);
        let nearest = NEAREST * self.focus.reach;
        for (who, actor, pose) in self.track.present(time) {
            draw_actor(&mut seen, &camera, who, actor, pose, nearest);
            shadow_actor(&mut stage.light, actor, pose);
        }
        for (who, sheet, places) in self.track.sheets_at(time) {
            sheet.draw(&mut seen, (&camera, nearest), who, &places);
            SheetActor::shade(&mut stage.light, &places);
        }
        (stage, camera, seen)
    }

    /// The moment with every sample shaded for itself.
    #[cfg(test)]
    pub(super) fn slow(&self, time: f64) -> Picture {
        let (stage, camera, seen) = self.set(time);
        slow(&Shot { stage: &stage, camera: &camera, seen: &seen }, self.size)
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
    let corners: Vec<ScreenCorner> = locals.iter().map(|local| camera.project(*local)).collect();
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
    let corners: Vec<ScreenCorner> = placed(actor, pose).map(|v| light.project(v)).collect();
    for &[a, b, c] in &actor.mesh.triangles {
        let corners = [corners[a as usize], corners[b as usize], corners[c as usize]];
        light.seen.triangle(corners, 0, || [Vec3::zeros(); 3]);
    }
}
