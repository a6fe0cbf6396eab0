//! Sheets over time: surfaces whose points move, with both of their faces.

use super::camera::Camera;
use super::corners::corner_normals;
use super::light::Light;
use super::raster::{Buffers, ScreenCorner};
use cullet_geometry::Vec3;
use cullet_proto::recording::SheetFrame;
use cullet_record::palette::{self, Rgb};
use cullet_record::{PieceCount, PlacedSheet, QuantityScale, Recording, ThickSheet};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Least thickness at which a sheet is drawn \[samples\]: half a pixel.
const LEAST_DRAWN: f64 = 1.0;

/// A sheet of a run.
#[derive(Debug)]
pub(super) struct SheetActor {
    pub(super) name: String,
    /// Where it shows no quantity.
    pub(super) colour: Rgb,
    /// Whether it shines as metals do.
    pub(super) metal: bool,
    /// By rising time.
    frames: Vec<SheetPlaces>,
    /// The quantity that diffuses as colours; nothing where none does, or where it is uniform.
    scale: Option<QuantityScale>,
    /// What came of its windows, by rising time.
    told: Vec<SheetTold>,
}

/// What came of a sheet by the end of a window.
#[derive(Clone, Copy, Debug)]
struct SheetTold {
    /// The end of the window \[s\].
    time: f64,
    pieces: PieceCount,
    /// Area of cracks at rest, length times thickness \[m²\].
    torn: f64,
}

/// Where the points of a sheet are at some time.
#[derive(Clone, Debug)]
pub(super) struct SheetPlaces {
    time: f64,
    shape: Arc<ThickSheet>,
    places: Vec<Vec3>,
    quantity: Vec<f32>,
}

impl SheetPlaces {
    /// Where its points are \[m\].
    pub(super) fn places(&self) -> &[Vec3] {
        &self.places
    }

    /// Between this and the next frame of the same surface.
    fn towards(&self, next: &Self, time: f64) -> Self {
        let share = (time - self.time) / (next.time - self.time);
        let places = self.places.iter().zip(&next.places).map(|(a, b)| a.lerp(b, share));
        let part = share as f32;
        let values = self.quantity.iter().zip(&next.quantity).map(|(a, b)| a + (b - a) * part);
        let quantity = if self.quantity.len() == next.quantity.len() {
            values.collect()
        } else {
            self.quantity.clone()
        };
        Self { time, shape: Arc::clone(&self.shape), places: places.collect(), quantity }
    }

    /// How far its points are from where they are in another frame, as a mean \[m\].
    fn moved(&self, from: &Self) -> f64 {
        let count = self.places.len().min(from.places.len()).max(1);
        let ways = self.places.iter().zip(&from.places).map(|(a, b)| (a - b).norm());
        ways.sum::<f64>() / count as f64
    }

    /// The surface as the eye sees it: thinner than half a pixel it is not drawn.
    fn drawn(&self, camera: &Camera) -> PlacedSheet {
        let least = 0.5 * LEAST_DRAWN / camera.focal;
        let half = |point: u32| {
            let away = camera.local(self.places[point as usize]).z;
            (0.5 * self.shape.thickness).max(least * away)
        };
        self.shape.placed(&self.places, half)
    }
}

impl SheetActor {
    /// The sheets of a recording. A frame that is damaged is left out.
    pub(super) fn all(recording: &Recording) -> Vec<Self> {
        let mut known: BTreeMap<&[u8], Option<DrawnSurface>> = BTreeMap::new();
        let mut sheets: BTreeMap<u32, (Self, (f32, f32))> = BTreeMap::new();
        for frame in &recording.sheet_frames {
            let surface =
                known.entry(&frame.surface).or_insert_with(|| DrawnSurface::of(recording, frame));
            let Some(surface) = surface.as_ref() else { continue };
            let Some(places) = surface.placed(frame) else { continue };
            let none = (f32::INFINITY, f32::NEG_INFINITY);
            let (sheet, span) =
                sheets.entry(frame.sheet).or_insert_with(|| (Self::new(frame), none));
            if sheet.frames.last().is_none_or(|last| last.time < places.time) {
                let values = places.quantity.iter();
                *span = values.fold(*span, |(low, high), &v| (low.min(v), high.max(v)));
                sheet.frames.push(places);
            }
        }
        for window in &recording.windows {
            if let Some((sheet, _)) = sheets.get_mut(&window.sheet) {
                let torn = window.ledger.as_ref().map_or(0.0, |ledger| ledger.torn_area);
                let pieces = PieceCount::of(window);
                sheet.told.push(SheetTold { time: window.time, pieces, torn });
            }
        }
        let scaled = |(sheet, span): (Self, _)| {
            let scale = QuantityScale::of(sheet.colour, span);
            Self { scale, ..sheet }
        };
        sheets.into_values().map(scaled).collect()
    }

    fn new(frame: &SheetFrame) -> Self {
        let colour = palette::colours(&frame.material, &frame.name, 0).0;
        let (name, metal) = (frame.name.clone(), palette::is_metal(&frame.material));
        Self { name, colour, metal, frames: Vec::new(), scale: None, told: Vec::new() }
    }

    /// Where it is, if it is there: between two frames of one surface on the straight way, and
    /// before another surface where it was last.
    pub(super) fn at(&self, time: f64) -> Option<Cow<'_, SheetPlaces>> {
        let next = self.frames.partition_point(|frame| frame.time <= time);
        let last = self.frames.get(next.checked_sub(1)?)?;
        let next = self.frames.get(next).filter(|next| Arc::ptr_eq(&next.shape, &last.shape));
        Some(match next {
            Some(next) if time > last.time => Cow::Owned(last.towards(next, time)),
            _ => Cow::Borrowed(last),
        })
    }

    fn told(&self, time: f64) -> Option<&SheetTold> {
        let next = self.told.partition_point(|told| told.time <= time);
        self.told.get(next.checked_sub(1)?)
    }

    /// How many pieces it has.
    pub(super) fn pieces(&self, time: f64) -> PieceCount {
        self.told(time).map_or(PieceCount { pieces: 1, crumbs: 0 }, |told| told.pieces)
    }

    /// How much of it is torn \[m²\].
    pub(super) fn torn(&self, time: f64) -> f64 {
        self.told(time).map_or(0.0, |told| told.torn)
    }

    /// When the first window ends in which it tears or comes apart \[s\]. What was cut as it began
    /// is none.
    pub(super) fn find_first_tear(&self) -> Option<f64> {
        let whole = self.told.first()?;
        let tears = |told: &&SheetTold| {
            told.torn > whole.torn || told.pieces.large() > whole.pieces.large()
        };
        self.told.iter().find(tears).map(|told| told.time)
    }

    /// When its windows end \[s\].
    pub(super) fn windows(&self) -> impl Iterator<Item = f64> {
        self.told.iter().map(|told| told.time)
    }

    /// When it has frames \[s\], and how far its points are then from where they were first, as a
    /// mean \[m\].
    pub(super) fn ways(&self) -> impl Iterator<Item = (f64, f64)> {
        let first = self.frames.first();
        let way = move |frame: &SheetPlaces| first.map_or(0.0, |first| frame.moved(first));
        self.frames.iter().map(move |frame| (frame.time, way(frame)))
    }

    /// When its last frame is \[s\].
    pub(super) fn end(&self) -> f64 {
        self.frames.last().map_or(0.0, |frame| frame.time)
    }

    /// Whether its colours show a quantity.
    pub(super) fn is_tinted(&self) -> bool {
        self.scale.is_some()
    }

    /// The colour at a share of the scale of its quantity.
    pub(super) fn tinted(&self, share: f32) -> Rgb {
        self.scale.as_ref().map_or(self.colour, |scale| scale.colour(share))
    }

    /// Draws it at a moment; what reaches behind the eye is left out.
    pub(super) fn draw(
        &self,
        seen: &mut Buffers,
        (camera, nearest): (&Camera, f64),
        who: u32,
        at: &SheetPlaces,
    ) {
        let drawn = at.drawn(camera);
        let locals: Vec<Vec3> = drawn.places.iter().map(|&p| camera.local(p)).collect();
        let corners: Vec<ScreenCorner> = locals.iter().map(|&p| camera.project(p)).collect();
        let tint = |scale: &QuantityScale, v: u32| {
            let point = at.shape.vertices[v as usize].point as usize;
            at.quantity.get(point).map_or(0.0, |&value| scale.share(value))
        };
        // What closes by itself has edges.
        let creased = (!at.shape.is_thick())
            .then(|| corner_normals(&drawn.places, &at.shape.triangles, |_, _| true));
        for (t, &[a, b, c]) in at.shape.triangles.iter().enumerate() {
            if [a, b, c].iter().any(|&v| locals[v as usize].z <= nearest) {
                continue;
            }
            let smooth = || [a, b, c].map(|v| drawn.normals[v as usize]);
            let own = creased.as_ref().map_or_else(smooth, |all| all[t]);
            let mut show = |[a, b, c]: [u32; 3], own: [Vec3; 3]| {
                let three = [a, b, c].map(|v| corners[v as usize]);
                let normals = || own;
                let tints = self.scale.as_ref().map(|scale| [a, b, c].map(|v| tint(scale, v)));
                seen.tinted_triangle(three, who, tints, normals);
            };
            show([a, b, c], own);
            // What has no thickness may be open: one of two shows its face to the eye.
            if !at.shape.is_thick() {
                show([a, c, b], [0, 2, 1].map(|k: usize| -own[k]));
            }
        }
    }

    /// Puts it in the way of the light.
    pub(super) fn shade(light: &mut Light, at: &SheetPlaces) {
        let placed = at.shape.at(&at.places);
        let corners: Vec<ScreenCorner> = placed.places.iter().map(|&p| light.project(p)).collect();
        for &[a, b, c] in &at.shape.triangles {
            for sides in [[a, b, c], [a, c, b]] {
                let three = sides.map(|v| corners[v as usize]);
                light.seen.triangle(three, 0, || [Vec3::zeros(); 3]);
            }
        }
    }
}

/// A surface as it is drawn.
struct DrawnSurface {
    shape: Arc<ThickSheet>,
    points: usize,
}

impl DrawnSurface {
    fn of(recording: &Recording, frame: &SheetFrame) -> Option<Self> {
        let surface = recording.surface_of(frame).ok()?;
        let points = surface.reference.len();
        Some(Self { shape: Arc::new(ThickSheet::of(&surface)), points })
    }

    fn placed(&self, frame: &SheetFrame) -> Option<SheetPlaces> {
        let places = frame.places(self.points).ok()?;
        let shape = Arc::clone(&self.shape);
        let (time, quantity) = (frame.time, frame.quantity.clone());
        Some(SheetPlaces { time, shape, places, quantity }).filter(|it| it.time.is_finite())
    }
}
