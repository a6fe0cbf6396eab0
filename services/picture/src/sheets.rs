//! Sheets over time: surfaces whose points move, seen from both sides.

use super::camera::Camera;
use super::light::Light;
use super::raster::{Buffers, ScreenCorner};
use cullet_geometry::Vec3;
use cullet_proto::recording::SheetFrame;
use cullet_record::Recording;
use cullet_record::palette::{self, Rgb};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A sheet of a run.
#[derive(Debug)]
pub(super) struct SheetActor {
    pub(super) name: String,
    /// Where it shows no quantity.
    pub(super) colour: Rgb,
    /// By rising time.
    frames: Vec<SheetPlaces>,
    /// Least and greatest value of the quantity that diffuses; nothing where none does.
    span: Option<(f32, f32)>,
    /// How many pieces it has from when on \[s\].
    pieces: Vec<(f64, usize)>,
}

/// Where the points of a sheet are from some time on.
#[derive(Debug)]
pub(super) struct SheetPlaces {
    time: f64,
    triangles: Arc<Vec<[u32; 3]>>,
    places: Vec<Vec3>,
    quantity: Vec<f32>,
}

impl SheetPlaces {
    /// Where its points are \[m\].
    pub(super) fn places(&self) -> &[Vec3] {
        &self.places
    }

    /// The unit normal at each point, on the upper side.
    fn normals(&self) -> Vec<Vec3> {
        let mut areas = vec![Vec3::zeros(); self.places.len()];
        for corners in &*self.triangles {
            let [a, b, c] = corners.map(|v| self.places[v as usize]);
            let area = (b - a).cross(&(c - a));
            corners.iter().for_each(|&v| areas[v as usize] += area);
        }
        areas.iter().map(|area| area.try_normalize(1e-300).unwrap_or_else(Vec3::z)).collect()
    }
}

impl SheetActor {
    /// The sheets of a recording. A frame that is damaged is left out.
    pub(super) fn all(recording: &Recording) -> Vec<Self> {
        let mut known: BTreeMap<&[u8], Option<DrawnSurface>> = BTreeMap::new();
        let mut sheets: BTreeMap<u32, Self> = BTreeMap::new();
        for frame in &recording.sheet_frames {
            let surface =
                known.entry(&frame.surface).or_insert_with(|| DrawnSurface::of(recording, frame));
            let Some(surface) = surface.as_ref() else { continue };
            let Some(places) = surface.placed(frame) else { continue };
            let sheet = sheets.entry(frame.sheet).or_insert_with(|| Self::new(frame));
            if sheet.frames.last().is_none_or(|last| last.time < places.time) {
                for &value in &places.quantity {
                    let (low, high) = sheet.span.unwrap_or((value, value));
                    sheet.span = Some((low.min(value), high.max(value)));
                }
                sheet.frames.push(places);
            }
        }
        for window in &recording.windows {
            if let Some(sheet) = sheets.get_mut(&window.sheet) {
                sheet.pieces.push((window.time, window.pieces.len()));
            }
        }
        sheets.into_values().collect()
    }

    fn new(frame: &SheetFrame) -> Self {
        let colour = palette::colours(&frame.material, &frame.name, 0).0;
        let name = frame.name.clone();
        Self { name, colour, frames: Vec::new(), span: None, pieces: Vec::new() }
    }

    /// Where it is, if it is there.
    pub(super) fn at(&self, time: f64) -> Option<&SheetPlaces> {
        let next = self.frames.partition_point(|frame| frame.time <= time);
        self.frames.get(next.checked_sub(1)?)
    }

    /// How many pieces it has.
    pub(super) fn pieces(&self, time: f64) -> usize {
        let next = self.pieces.partition_point(|(since, _)| *since <= time);
        next.checked_sub(1).map_or(1, |last| self.pieces[last].1)
    }

    /// When its surface became another \[s\]: when it tore on.
    pub(super) fn tears(&self) -> impl Iterator<Item = f64> {
        let pairs = self.frames.windows(2);
        let torn = pairs.filter(|pair| !Arc::ptr_eq(&pair[0].triangles, &pair[1].triangles));
        torn.map(|pair| pair[1].time)
    }

    /// When its last frame is \[s\].
    pub(super) fn end(&self) -> f64 {
        self.frames.last().map_or(0.0, |frame| frame.time)
    }

    /// Whether its colours show a quantity.
    pub(super) fn is_tinted(&self) -> bool {
        self.span.is_some()
    }

    /// The quantity at a corner between its least and its greatest \[1\].
    fn tint(&self, at: &SheetPlaces, corner: u32) -> f32 {
        let (low, high) = self.span.unwrap_or_default();
        let value = at.quantity.get(corner as usize).copied().unwrap_or(low);
        if high > low { (value - low) / (high - low) } else { 0.0 }
    }

    /// Draws it at a moment; what reaches behind the eye is left out.
    pub(super) fn draw(
        &self,
        seen: &mut Buffers,
        (camera, nearest): (&Camera, f64),
        who: u32,
        at: &SheetPlaces,
    ) {
        let locals: Vec<Vec3> = at.places.iter().map(|&p| camera.local(p)).collect();
        let corners: Vec<ScreenCorner> = locals.iter().map(|&p| camera.project(p)).collect();
        let normals = at.normals();
        for &[a, b, c] in &*at.triangles {
            if [a, b, c].iter().any(|&v| locals[v as usize].z <= nearest) {
                continue;
            }
            // One of the two shows its face to the eye, and has the normal of that side.
            for ([a, b, c], side) in [([a, b, c], 1.0), ([a, c, b], -1.0)] {
                let three = [a, b, c].map(|v| corners[v as usize]);
                let normals = || [a, b, c].map(|v| normals[v as usize] * side);
                let tints = self.span.map(|_| [a, b, c].map(|v| self.tint(at, v)));
                seen.tinted_triangle(three, who, tints, normals);
            }
        }
    }

    /// Puts it in the way of the light.
    pub(super) fn shade(light: &mut Light, at: &SheetPlaces) {
        let corners: Vec<ScreenCorner> = at.places.iter().map(|&p| light.project(p)).collect();
        for &[a, b, c] in &*at.triangles {
            for sides in [[a, b, c], [a, c, b]] {
                let three = sides.map(|v| corners[v as usize]);
                light.seen.triangle(three, 0, || [Vec3::zeros(); 3]);
            }
        }
    }
}

/// A surface as it is drawn.
struct DrawnSurface {
    triangles: Arc<Vec<[u32; 3]>>,
    points: usize,
}

impl DrawnSurface {
    fn of(recording: &Recording, frame: &SheetFrame) -> Option<Self> {
        let surface = recording.surface_of(frame).ok()?;
        let points = surface.reference.len();
        Some(Self { triangles: Arc::new(surface.triangles), points })
    }

    fn placed(&self, frame: &SheetFrame) -> Option<SheetPlaces> {
        let places = frame.places(self.points).ok()?;
        let triangles = Arc::clone(&self.triangles);
        let (time, quantity) = (frame.time, frame.quantity.clone());
        Some(SheetPlaces { time, triangles, places, quantity }).filter(|it| it.time.is_finite())
    }
}
