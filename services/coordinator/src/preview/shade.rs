//! Pixels to colours: one key light with a soft shadow, sky and floor as ambient light, darkening
//! where surfaces meet, thin lines around bodies, a checkered floor that fades into the sky.

use super::camera::Camera;
use super::raster::{Buffers, NOBODY};
use super::stage::Stage;
use cullet_geometry::Vec3;

/// Linear light, red, green, blue.
pub(super) type Colour = [f32; 3];

const KEY: Colour = [1.18, 1.10, 0.98];
const SKY_LIGHT: Colour = [0.44, 0.49, 0.56];
const FLOOR_LIGHT: Colour = [0.27, 0.25, 0.23];
const HORIZON: Colour = [0.80, 0.82, 0.84];
const ZENITH: Colour = [0.46, 0.58, 0.72];
const FLOOR: [Colour; 2] = [[0.50, 0.49, 0.47], [0.44, 0.43, 0.415]];
/// Marks a crack face in the buffer of who is seen.
pub(super) const CRACK: u32 = 1 << 31;
/// How much of its light a pixel keeps beside another body, and beside what stands behind it.
const LINE: f32 = 0.52;
/// Pixels that darkening by nearby surfaces looks at, in eighths of the reach.
const AROUND: [(f32, f32); 6] =
    [(8.0, 1.0), (-3.0, 2.0), (1.0, -7.0), (2.0, 4.0), (-6.0, -4.0), (4.0, -3.0)];

/// Who is seen there, without the mark of a crack face.
fn body(who: u32) -> u32 {
    if who == NOBODY { NOBODY } else { who & !CRACK }
}

/// The picture as rows of linear colours.
pub(super) fn shade(stage: &Stage<'_>, camera: &Camera, seen: &Buffers) -> Vec<Colour> {
    let mut out = Vec::with_capacity(seen.width * seen.height);
    for y in 0..seen.height {
        for x in 0..seen.width {
            out.push(pixel(stage, camera, seen, x, y));
        }
    }
    out
}

fn pixel(stage: &Stage<'_>, camera: &Camera, seen: &Buffers, x: usize, y: usize) -> Colour {
    let index = y * seen.width + x;
    let ray = camera.ray(x, y);
    let who = seen.who[index];
    if who == NOBODY {
        return background(stage, camera, ray, (x, y));
    }
    let distance = 1.0 / f64::from(seen.near[index]);
    let point = camera.eye + ray * distance;
    let n = seen.normal[index].map(f64::from);
    let normal = Vec3::from(n).try_normalize(1e-12).unwrap_or(stage.up);
    let at = Surface { point, normal, pixel: (x, y) };
    let actor = &stage.track.actors[body(who) as usize];
    let lit = if actor.fixed {
        let floor = normal.dot(&stage.up) > 0.9;
        let base = if floor { checker(stage, point) } else { FLOOR[0] };
        let lit = light(stage, &at, base, open(seen, stage, x, y));
        if floor { fade(stage, camera, ray, point, lit) } else { lit }
    } else {
        let base = if who & CRACK == 0 { actor.outer } else { actor.inner };
        // Screen colours to light.
        let base = base.map(|c| c * c);
        light(stage, &at, base, open(seen, stage, x, y))
    };
    let line = outline(stage, seen, x, y);
    lit.map(|c| c * line)
}

/// A point of a surface, and where it is seen.
struct Surface {
    point: Vec3,
    normal: Vec3,
    pixel: (usize, usize),
}

fn light(stage: &Stage<'_>, at: &Surface, base: Colour, open: f32) -> Colour {
    let (key, up, normal) = (&stage.light, stage.up, at.normal);
    let facing = normal.dot(&key.towards).max(0.0) as f32;
    let lit = if facing > 0.0 { facing * key.reaches(at.point, normal, at.pixel) } else { 0.0 };
    let upward = 0.5 + 0.5 * normal.dot(&up) as f32;
    std::array::from_fn(|i| {
        let ambient = SKY_LIGHT[i] * upward + FLOOR_LIGHT[i] * (1.0 - upward);
        base[i] * (KEY[i] * lit + ambient * open)
    })
}

fn checker(stage: &Stage<'_>, point: Vec3) -> Colour {
    let (u, v) = stage.floor_axes;
    let cell = |axis: Vec3| (point.dot(&axis) / stage.tile).floor() as i64;
    FLOOR[(cell(u) + cell(v)).rem_euclid(2) as usize]
}

/// The floor far away goes over into the horizon.
fn fade(stage: &Stage<'_>, camera: &Camera, ray: Vec3, point: Vec3, colour: Colour) -> Colour {
    let far = (point - camera.eye).norm() / stage.reach;
    let share = ((far - 2.5) / 9.0).clamp(0.0, 1.0) as f32;
    let share = share * share * (3.0 - 2.0 * share);
    let sky = sky(stage, ray);
    std::array::from_fn(|i| colour[i] + (sky[i] - colour[i]) * share)
}

fn sky(stage: &Stage<'_>, ray: Vec3) -> Colour {
    let height = (ray.dot(&stage.up) / ray.norm()).clamp(0.0, 1.0) as f32;
    let share = (height * 2.2).min(1.0);
    std::array::from_fn(|i| HORIZON[i] + (ZENITH[i] - HORIZON[i]) * share)
}

/// The sky, or a floor of our own in a scene without one.
fn background(stage: &Stage<'_>, camera: &Camera, ray: Vec3, pixel: (usize, usize)) -> Colour {
    let down = ray.dot(&stage.up);
    let Some(level) = stage.floor.filter(|_| down < -1e-6) else {
        return sky(stage, ray);
    };
    let along = (level - camera.eye.dot(&stage.up)) / down;
    if along <= 0.0 {
        return sky(stage, ray);
    }
    let point = camera.eye + ray * along;
    let at = Surface { point, normal: stage.up, pixel };
    let lit = light(stage, &at, checker(stage, point), 1.0);
    fade(stage, camera, ray, point, lit)
}

/// Share of the ambient light that surfaces close by let through.
fn open(seen: &Buffers, stage: &Stage<'_>, x: usize, y: usize) -> f32 {
    let index = y * seen.width + x;
    let here = 1.0 / seen.near[index];
    let reach = stage.contact as f32;
    let focal = stage.focal as f32;
    let radius = (focal * reach / here).clamp(2.0, 40.0) / 8.0;
    // How much nearer the plane of this surface comes with each pixel to the right and down [m].
    let [nx, ny, nz] = stage.to_eye(seen.normal[index]);
    // Seen edge-on, any neighbour may be nearer without standing over it.
    let steep = here / focal / (-nz).max(0.15);
    let (right, down) = (-nx * steep, ny * steep);
    let mut shut = 0.0;
    for (dx, dy) in AROUND {
        // The pattern turns from pixel to pixel; averaging the samples of a pixel smooths it.
        let (dx, dy) = turned(dx, dy, x, y);
        let (du, dv) = ((dx * radius) as i64, (dy * radius) as i64);
        let (u, v) = (x as i64 + du, y as i64 + dv);
        if u < 0 || v < 0 || u >= seen.width as i64 || v >= seen.height as i64 {
            continue;
        }
        let near = seen.near[v as usize * seen.width + u as usize];
        if near <= 0.0 {
            continue;
        }
        // A surface that stands well before this one hides it without touching it.
        let nearer = here - 1.0 / near;
        let over = nearer - (right * du as f32 + down * dv as f32);
        if over > 0.02 * reach && nearer < 3.0 * reach {
            shut += (over / reach).min(1.0);
        }
    }
    1.0 - 0.85 * (shut / AROUND.len() as f32).min(1.0)
}

/// Turns a pattern by quarters, another one at each pixel of a block of four.
pub(super) fn turned(dx: f32, dy: f32, x: usize, y: usize) -> (f32, f32) {
    match (x & 1, y & 1) {
        (0, 0) => (dx, dy),
        (1, 0) => (-dy, dx),
        (0, _) => (dy, -dx),
        _ => (-dx, -dy),
    }
}

/// Darkens a pixel whose right or lower neighbour belongs to someone else.
fn outline(stage: &Stage<'_>, seen: &Buffers, x: usize, y: usize) -> f32 {
    let index = y * seen.width + x;
    let here = seen.who[index];
    let moves = |who: u32| who != NOBODY && !stage.track.actors[body(who) as usize].fixed;
    let mut kept = 1.0_f32;
    let right = (x + 1 < seen.width).then_some(index + 1);
    let below = (y + 1 < seen.height).then_some(index + seen.width);
    for other in [right, below].into_iter().flatten() {
        let there = seen.who[other];
        if there == here || !(moves(here) || moves(there)) {
            continue;
        }
        let other_body = body(there) != body(here);
        kept = kept.min(if other_body { LINE } else { 0.85 });
    }
    kept
}
