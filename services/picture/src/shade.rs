//! Pixels to colours: one key light with a soft shadow, sky and floor as ambient light, darkening
//! where surfaces meet, thin lines around bodies, a chequered floor that fades into the sky.

use super::camera::Camera;
use super::change::ChangedTiles;
use super::light::TAP_REACH;
use super::occlusion::FARTHEST;
use super::picture::Picture;
use super::raster::{Buffers, NOBODY};
use super::stage::{RenderContext, SAMPLES};
use cullet_geometry::Vec3;
use cullet_record::palette::Rgb;
use std::ops::Range;

/// Linear light, red, green, blue.
pub(super) type LinearRgb = [f32; 3];

const KEY: LinearRgb = [1.18, 1.10, 0.98];
const SKY_LIGHT: LinearRgb = [0.44, 0.49, 0.56];
const FLOOR_LIGHT: LinearRgb = [0.27, 0.25, 0.23];
const HORIZON: LinearRgb = [0.80, 0.82, 0.84];
const ZENITH: LinearRgb = [0.46, 0.58, 0.72];
const FLOOR: [LinearRgb; 2] = [[0.50, 0.49, 0.47], [0.44, 0.43, 0.415]];
/// Marks a crack face in the buffer of who is seen.
pub(super) const CRACK: u32 = 1 << 31;
/// How much of its light a pixel keeps beside another body, and beside what stands behind it.
const LINE: f32 = 0.52;
/// A pixel's samples are shaded as one if their normals differ by no more than this \[1\] …
const ALIKE: f32 = 0.05;
/// … and their distances by no more than this share \[1\].
const LEVEL: f32 = 0.02;

/// Shares of what a metal scatters, mirrors and has as gleam of the key light \[1\].
const SCATTERED: f32 = 0.5;
const MIRRORED: f32 = 0.7;
const GLEAM: f32 = 0.9;

/// Who is seen there, without the mark of a crack face.
fn body(who: u32) -> u32 {
    if who == NOBODY { NOBODY } else { who & !CRACK }
}

/// Samples of a pixel.
const COUNT: usize = SAMPLES * SAMPLES;
/// Where they are.
type Samples = [(usize, usize); COUNT];
/// The tile of the light's picture that each of them asked, or [`UNASKED`].
type RequestedTiles = [u32; COUNT];

/// Marks a sample that asks nothing of the light's picture.
const UNASKED: u32 = u32::MAX;

/// What changed since a picture was shaded, on the screen and in the light's picture.
pub(super) struct Changed {
    screen: ChangedTiles,
    light: ChangedTiles,
}

impl Changed {
    pub(super) fn between(old: (&Buffers, &Buffers), new: (&Buffers, &Buffers)) -> Self {
        Self {
            screen: ChangedTiles::between(old.0, new.0).spread(FARTHEST),
            light: ChangedTiles::between(old.1, new.1).spread(TAP_REACH),
        }
    }

    fn touches(&self, tile: usize, asked: &RequestedTiles) -> bool {
        let touched = |tile: &u32| *tile != UNASKED && self.light.touched(*tile as usize);
        self.screen.touched(tile) || asked.iter().any(touched)
    }
}

/// A shaded picture.
pub(super) struct Shaded {
    pub(super) picture: Picture,
    asked: Vec<RequestedTiles>,
}

impl Shaded {
    pub(super) fn nothing((width, height): (usize, usize)) -> Self {
        let asked = vec![[UNASKED; COUNT]; width * height];
        Self { picture: Picture::filled(width, height, [0; 3]), asked }
    }

    /// Shades every pixel, or those that `changed` may have touched.
    pub(super) fn shade(&mut self, shot: &Shot<'_>, changed: Option<&Changed>) {
        let (width, height) = (self.picture.width, self.picture.height);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let asked = &mut self.asked[y * width + x];
            let tile = ChangedTiles::tile(shot.seen.width, x * SAMPLES, y * SAMPLES);
            if changed.is_none_or(|changed| changed.touches(tile, asked)) {
                let (colour, tiles) = shot.pixel((x * SAMPLES, y * SAMPLES));
                *asked = tiles;
                self.picture.set(x, y, colour.map(screen));
            }
        }
    }
}

/// Light to a byte of the screen: bright parts roll off instead of burning out.
fn screen(light: f32) -> u8 {
    let soft = if light > 0.7 { 0.7 + 0.3 * (light - 0.7) / (light - 0.4) } else { light };
    (soft.max(0.0).sqrt() * 255.0 + 0.5) as u8
}

/// All that a pixel's colour depends on.
pub(super) struct Shot<'a> {
    pub(super) stage: &'a RenderContext<'a>,
    pub(super) camera: &'a Camera,
    pub(super) seen: &'a Buffers,
}

/// A colour, and the tile of the light's picture that decided it.
type Lit = (LinearRgb, u32);

/// A point of a surface, and the quarter turns of the patterns that it is looked at with.
struct SurfacePoint {
    point: Vec3,
    normal: Vec3,
    turns: Range<usize>,
}

impl Shot<'_> {
    /// A pixel, from its samples together if they are alike; `corner` is the first of them.
    fn pixel(&self, corner: (usize, usize)) -> (LinearRgb, RequestedTiles) {
        let samples = samples(corner);
        if !self.alike(&samples) {
            return self.mean(&samples);
        }
        let (colour, tile) = self.together(&samples);
        let mut asked = [UNASKED; COUNT];
        asked[0] = tile;
        (colour.map(|c| c.clamp(0.0, 4.0)), asked)
    }

    /// The mean of samples, each shaded for itself.
    fn mean(&self, samples: &Samples) -> (LinearRgb, RequestedTiles) {
        let mut asked = [UNASKED; COUNT];
        let mut sum = [0.0_f32; 3];
        for (k, &(x, y)) in samples.iter().enumerate() {
            let (colour, tile) = self.sample(x, y);
            sum = std::array::from_fn(|i| sum[i] + colour[i].clamp(0.0, 4.0));
            asked[k] = tile;
        }
        (sum.map(|c| c / COUNT as f32), asked)
    }

    /// Whether a pixel's samples show one smooth piece of a surface.
    fn alike(&self, samples: &Samples) -> bool {
        let index = samples.map(|(x, y)| y * self.seen.width + x);
        let (who, near) = (self.seen.who[index[0]], self.seen.near[index[0]]);
        if index.iter().any(|&i| self.seen.who[i] != who) {
            return false;
        }
        if who == NOBODY {
            // A floor of our own has tiles, whose edges need every sample.
            return self.stage.floor.is_none();
        }
        let normal = self.seen.normal[index[0]];
        index[1..].iter().all(|&i| {
            let apart = (0..3).map(|k| (self.seen.normal[i][k] - normal[k]).abs());
            (self.seen.near[i] - near).abs() < LEVEL * near && apart.sum::<f32>() < ALIKE
        })
    }

    /// The colour of samples that are alike: lit once, with the patterns of all of them.
    fn together(&self, samples: &Samples) -> Lit {
        let (x, y) = samples[0];
        let middle = (x as f64 + SAMPLES as f64 / 2.0, y as f64 + SAMPLES as f64 / 2.0);
        let ray = self.camera.ray_at(middle);
        let first = y * self.seen.width + x;
        let who = self.seen.who[first];
        if who == NOBODY {
            return self.background(ray, 0..COUNT);
        }
        let index = samples.map(|(x, y)| y * self.seen.width + x);
        let near = index.iter().map(|&i| f64::from(self.seen.near[i])).sum::<f64>() / COUNT as f64;
        let floor = |_: Vec3| {
            let spots = samples.iter().zip(index).map(|(&(x, y), i)| {
                self.camera.eye + self.camera.ray(x, y) / f64::from(self.seen.near[i])
            });
            let mean = spots.map(|spot| checker(self.stage, spot));
            mean.fold([0.0; 3], |sum, c| std::array::from_fn(|i| sum[i] + c[i] / COUNT as f32))
        };
        let (lit, asked) = self.surface(who, ray, near, first, 0..COUNT, floor);
        let line = samples.iter().map(|&(x, y)| outline(self.stage, self.seen, x, y)).sum::<f32>()
            / COUNT as f32;
        (lit.map(|c| c * line), asked)
    }

    fn sample(&self, x: usize, y: usize) -> Lit {
        let index = y * self.seen.width + x;
        let ray = self.camera.ray(x, y);
        let who = self.seen.who[index];
        let turn = x % SAMPLES + y % SAMPLES * SAMPLES;
        if who == NOBODY {
            return self.background(ray, turn..turn + 1);
        }
        let near = f64::from(self.seen.near[index]);
        let floor = |point| checker(self.stage, point);
        let (lit, asked) = self.surface(who, ray, near, index, turn..turn + 1, floor);
        let line = outline(self.stage, self.seen, x, y);
        (lit.map(|c| c * line), asked)
    }

    /// What `ray` meets at 1/`near`; `index` is the sample whose neighbours may darken it.
    fn surface(
        &self,
        who: u32,
        ray: Vec3,
        near: f64,
        index: usize,
        turns: Range<usize>,
        floor: impl Fn(Vec3) -> LinearRgb,
    ) -> Lit {
        let stage = self.stage;
        let point = self.camera.eye + ray / near;
        let n = self.seen.normal[index].map(f64::from);
        let normal = Vec3::from(n).try_normalize(1e-12).unwrap_or(stage.up);
        let open = stage.occlusion.open(&stage.view, self.seen, index, turns.clone());
        let at = SurfacePoint { point, normal, turns };
        let actor = stage.track.actor(body(who));
        if !actor.fixed {
            let plain = if who & CRACK == 0 { actor.outer } else { actor.inner };
            // Screen colours to light.
            let base = self.tint(body(who), index).unwrap_or(plain).map(|c| c * c);
            let lit = light(stage, &at, base, open);
            let metal = stage.track.sheet(body(who)).is_some_and(|sheet| sheet.metal);
            return if metal { (shine(stage, &at, ray, base, (lit.0, open)), lit.1) } else { lit };
        }
        if at.normal.dot(&stage.up) <= 0.9 {
            return light(stage, &at, FLOOR[0], open);
        }
        let (lit, asked) = light(stage, &at, floor(point), open);
        (fade(stage, self.camera, ray, point, lit), asked)
    }

    /// The colour of the quantity that a surface shows at a sample, if it does.
    fn tint(&self, who: u32, index: usize) -> Option<Rgb> {
        let &share = self.seen.tint.get(index)?;
        let sheet = self.stage.track.sheet(who).filter(|sheet| sheet.is_tinted())?;
        Some(sheet.tinted(share))
    }

    /// The sky, or a floor of our own in a scene without one.
    fn background(&self, ray: Vec3, turns: Range<usize>) -> Lit {
        let (stage, camera) = (self.stage, self.camera);
        let down = ray.dot(&stage.up);
        let Some(level) = stage.floor.filter(|_| down < -1e-6) else {
            return (sky(stage, ray), UNASKED);
        };
        let along = (level - camera.eye.dot(&stage.up)) / down;
        if along <= 0.0 {
            return (sky(stage, ray), UNASKED);
        }
        let point = camera.eye + ray * along;
        let at = SurfacePoint { point, normal: stage.up, turns };
        let (lit, asked) = light(stage, &at, checker(stage, point), 1.0);
        (fade(stage, camera, ray, point, lit), asked)
    }
}

/// The samples of a pixel, from the first one.
fn samples((x, y): (usize, usize)) -> Samples {
    std::array::from_fn(|k| (x + k % SAMPLES, y + k / SAMPLES))
}

fn light(stage: &RenderContext<'_>, at: &SurfacePoint, base: LinearRgb, open: f32) -> Lit {
    let (key, up, normal) = (&stage.light, stage.up, at.normal);
    let facing = normal.dot(&key.towards).max(0.0) as f32;
    let (mut lit, mut asked) = (0.0, UNASKED);
    if facing > 0.0 {
        let (share, tile) = key.reaches(at.point, normal, at.turns.clone());
        (lit, asked) = (facing * share, tile.unwrap_or(UNASKED));
    }
    let upward = 0.5 + 0.5 * normal.dot(&up) as f32;
    let colour = std::array::from_fn(|i| {
        let ambient = SKY_LIGHT[i] * upward + FLOOR_LIGHT[i] * (1.0 - upward);
        base[i] * (KEY[i] * lit + ambient * open)
    });
    (colour, asked)
}

/// A metal: it shows sky and floor around it and the key light, besides what it scatters.
fn shine(
    stage: &RenderContext<'_>,
    at: &SurfacePoint,
    ray: Vec3,
    base: LinearRgb,
    (scattered, open): (LinearRgb, f32),
) -> LinearRgb {
    let way = ray.try_normalize(1e-300).unwrap_or(-at.normal);
    let back = way - at.normal * (2.0 * way.dot(&at.normal));
    // A surface that is a little rough mixes what lies above and below the horizon.
    let above = (0.5 + 2.0 * back.dot(&stage.up)).clamp(0.0, 1.0) as f32;
    let (sky, floor) = (sky(stage, back), FLOOR[1]);
    let towards = back.dot(&stage.light.towards).max(0.0) as f32;
    let spot = (0..3).fold(towards * towards, |power, _| power * power);
    std::array::from_fn(|i| {
        let around = floor[i] + (sky[i] - floor[i]) * above;
        SCATTERED * scattered[i] + base[i] * (MIRRORED * around * open + GLEAM * KEY[i] * spot)
    })
}

fn checker(stage: &RenderContext<'_>, point: Vec3) -> LinearRgb {
    let (u, v) = stage.floor_axes;
    let cell = |axis: Vec3| whole(point.dot(&axis) / stage.tile);
    FLOOR[(cell(u) + cell(v)).rem_euclid(2) as usize]
}

/// The greatest whole number not above `x`; without the call that `floor` is on old machines.
fn whole(x: f64) -> i64 {
    let cut = x as i64;
    cut - i64::from(x < cut as f64)
}

/// The floor far away goes over into the horizon.
fn fade(
    stage: &RenderContext<'_>,
    camera: &Camera,
    ray: Vec3,
    point: Vec3,
    colour: LinearRgb,
) -> LinearRgb {
    let far = (point - camera.eye).norm() / stage.reach;
    let share = ((far - 2.5) / 9.0).clamp(0.0, 1.0) as f32;
    if share == 0.0 {
        return colour;
    }
    let share = share * share * (3.0 - 2.0 * share);
    let sky = sky(stage, ray);
    std::array::from_fn(|i| colour[i] + (sky[i] - colour[i]) * share)
}

fn sky(stage: &RenderContext<'_>, ray: Vec3) -> LinearRgb {
    let height = (ray.dot(&stage.up) / ray.norm()).clamp(0.0, 1.0) as f32;
    let share = (height * 2.2).min(1.0);
    std::array::from_fn(|i| HORIZON[i] + (ZENITH[i] - HORIZON[i]) * share)
}

/// Darkens a pixel whose right or lower neighbour belongs to someone else.
fn outline(stage: &RenderContext<'_>, seen: &Buffers, x: usize, y: usize) -> f32 {
    let index = y * seen.width + x;
    let here = seen.who[index];
    let moves = |who: u32| who != NOBODY && !stage.track.actor(body(who)).fixed;
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

/// The slow twin: every sample shaded for itself.
#[cfg(test)]
pub(super) fn slow(shot: &Shot<'_>, (width, height): (usize, usize)) -> Picture {
    let mut picture = Picture::filled(width, height, [0; 3]);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let (colour, _) = shot.mean(&samples((x * SAMPLES, y * SAMPLES)));
        picture.set(x, y, colour.map(screen));
    }
    picture
}
