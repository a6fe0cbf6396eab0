//! Points coloured by a number: four moments side by side, the last one last.

use super::camera::Camera;
use super::letters::Typeface;
use super::picture::Picture;
use super::{contact_sheet, raster::ScreenCorner};
use cullet_geometry::Vec3;
use cullet_proto::specimen::Frame;
pub use cullet_record::scale::{colour, range};

/// Pixels of a moment.
const SIZE: (usize, usize) = (480, 360);
/// Moments shown.
const MOMENTS: usize = 4;
/// Behind the points.
const GROUND: [u8; 3] = [246, 246, 243];
/// Letters of the scale.
const INK: [u8; 3] = [70, 72, 76];
/// Height of a caption's line.
const CAPTION: usize = 20;
/// Height of the strip that it stands in.
const STRIP: usize = 20;
/// Pixels that its colours take.
const BAR: usize = 120;
/// An extent below this share of the next is seen face on \[1\].
const FLAT: f64 = 0.34;

/// Draws four moments, evenly spread from the first frame after the start to the last. `what` the
/// colours tell stands at their scale, on each.
#[must_use]
pub fn sheet(frames: &[Frame], what: &str) -> Picture {
    let last = frames.len().saturating_sub(1);
    let shown = (1..=MOMENTS).map(|k| frames.get(last * k / MOMENTS));
    let span = range(frames);
    let all: Vec<Vec3> =
        frames.iter().flat_map(|f| f.points.iter().map(place)).filter(is_finite).collect();
    let camera = view(&all);
    let size = frames.first().map_or(1.0, distance);
    let pictures: Vec<Picture> = shown
        .flatten()
        .map(|frame| {
            let mut picture = draw(frame, &camera, size, span);
            scale(&mut picture, span, what);
            picture.caption(&format!("{:.3e} s", frame.time), Typeface::of_height(CAPTION));
            picture
        })
        .collect();
    contact_sheet(&pictures)
}

/// The colours from the least value of all moments to the greatest, along the upper edge.
fn scale(picture: &mut Picture, (low, high): (f32, f32), what: &str) {
    let face = Typeface::SMALL;
    let top = (STRIP - face.line_height()) / 2;
    let mut left = STRIP / 2;
    let mut write = |picture: &mut Picture, text: &str| {
        picture.write(text, face, (left, top), INK);
        left += face.text_width(text) + STRIP / 2;
        left
    };
    write(picture, what);
    if !low.is_finite() || !high.is_finite() {
        return;
    }
    let bar = write(picture, &format!("{low:.2e}"));
    for x in 0..BAR {
        let value = low + (high - low) * x as f32 / (BAR - 1) as f32;
        let rgb = colour(value, (low, high));
        (0..face.line_height()).for_each(|y| picture.set(bar + x, top + y, rgb));
    }
    let end = bar + BAR + STRIP / 2;
    picture.write(&format!("{high:.2e}"), face, (end, top), INK);
}

fn place(point: &[f32; 4]) -> Vec3 {
    Vec3::new(point[0].into(), point[1].into(), point[2].into())
}

fn is_finite(x: &Vec3) -> bool {
    x.iter().all(|c| c.is_finite())
}

/// Flat bodies are seen face on, others from a corner.
fn view(points: &[Vec3]) -> Camera {
    let (low, high) = cullet_geometry::mesh::bounds(points).unwrap_or_default();
    let extent = high - low;
    let axis = extent.imin();
    let next = (0..3).filter(|&a| a != axis).map(|a| extent[a]).fold(f64::INFINITY, f64::min);
    let corners: Vec<Vec3> = (0..8)
        .map(|k| Vec3::from([0, 1, 2].map(|a| if k >> a & 1 == 1 { high[a] } else { low[a] })))
        .collect();
    let flat = extent[axis] < FLAT * next;
    let forward = if flat { -Vec3::ith(axis, 1.0) } else { Vec3::new(-0.6, 0.7, -0.45) };
    let up = if flat && axis == 2 { Vec3::y() } else { Vec3::z() };
    Camera::fit(&corners, forward, up, SIZE)
}

/// About how far points are apart \[m\].
fn distance(frame: &Frame) -> f64 {
    let points: Vec<Vec3> = frame.points.iter().map(place).filter(is_finite).collect();
    let (low, high) = cullet_geometry::mesh::bounds(&points).unwrap_or_default();
    libm::cbrt((high - low).product() / points.len().max(1) as f64)
}

fn draw(frame: &Frame, camera: &Camera, size: f64, span: (f32, f32)) -> Picture {
    let mut picture = Picture::filled(SIZE.0, SIZE.1, GROUND);
    let mut depth = vec![0.0_f64; SIZE.0 * SIZE.1];
    for point in frame.points.iter().filter(|point| is_finite(&place(point))) {
        let local = camera.local(place(point));
        if local.z <= 1e-9 {
            continue;
        }
        let ScreenCorner { x, y, near } = camera.project(local);
        let radius = (0.75 * size * camera.focal * near).clamp(0.7, 30.0);
        let rgb = colour(point[3], span);
        let (left, right) = ((x - radius).max(0.0) as usize, (x + radius).max(0.0) as usize);
        let (top, bottom) = ((y - radius).max(0.0) as usize, (y + radius).max(0.0) as usize);
        for v in top..(bottom + 1).min(SIZE.1) {
            for u in left..(right + 1).min(SIZE.0) {
                let (dx, dy) = (u as f64 + 0.5 - x, v as f64 + 0.5 - y);
                let square = (dx * dx + dy * dy) / (radius * radius);
                let pixel = &mut depth[v * SIZE.0 + u];
                if square <= 1.0 && near > *pixel {
                    *pixel = near;
                    // Darker towards the rim, so that points can be distinguished.
                    let shade = 1.0 - 0.35 * square;
                    picture.set(u, v, rgb.map(|c| (f64::from(c) * shade) as u8));
                }
            }
        }
    }
    picture
}
