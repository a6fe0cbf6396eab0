//! What came of a window: a header, then its slabs.

use super::poses;
use crate::bounds::{MAX_DETAILS, MAX_PROXIES, MAX_WARNINGS, MAX_WINDOW_STEPS, cut};
use crate::codec::{self, WireError};
use crate::envelope::{self, MessageKind};
use crate::mesh::{self, Slabs};
use cullet_geometry::Vec3;
use cullet_model::sheet_check::MAX_STATE;
use cullet_model::{
    Figure, Handed, MovingSurface, SettledPiece, SurfaceFrame, SweptExtent, TornPiece,
    WindowLedger, WindowOutcome,
};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Most frames of one window, and most surfaces.
const MAX_FRAMES: u64 = MAX_WINDOW_STEPS;
/// Most points of a moving surface, and most of its triangles.
const MAX_POINTS: u64 = 1 << 22;
/// Most pieces.
const MAX_PIECES: u64 = 1 << 17;
/// Most pieces that come to rest in a window.
const MAX_SETTLED: u64 = 256;
/// Bytes of a piece: three numbers, a mark, a step, mass and area.
const PIECE: usize = 36;

#[derive(Serialize, Deserialize)]
struct HandedRow {
    body: u64,
    steps: u32,
}

#[derive(Serialize, Deserialize)]
struct FrameRow {
    step: u64,
    surface: u32,
    origin: [f64; 3],
    points: u32,
    quantity: bool,
}

#[derive(Serialize, Deserialize)]
struct SettledRow {
    number: u32,
    vertices: u32,
    triangles: u32,
    place: [f64; 3],
    mass: f64,
}

#[derive(Serialize, Deserialize)]
struct OutcomeHeader {
    state: u64,
    extent: SweptExtent,
    handed: Vec<HandedRow>,
    /// Triangles, points and thickness of each.
    surfaces: Vec<(u32, u32, f32)>,
    frames: Vec<FrameRow>,
    pieces: u32,
    settled: Vec<SettledRow>,
    ledger: WindowLedger,
    figures: Vec<Figure>,
    warnings: Vec<String>,
}

/// The bytes of an outcome. Figures and warnings over their limits are cut.
///
/// # Errors
/// The limit of the wire that it breaks.
pub fn encode_outcome(outcome: &WindowOutcome) -> Result<Vec<u8>, WireError> {
    let row =
        |handed: &Handed| HandedRow { body: handed.body, steps: handed.impulses.len() as u32 };
    let frame = |frame: &SurfaceFrame| FrameRow {
        step: frame.step,
        surface: frame.surface,
        origin: frame.origin.into(),
        points: frame.offsets.len() as u32,
        quantity: !frame.quantity.is_empty(),
    };
    let counts =
        |s: &MovingSurface| (s.triangles.len() as u32, s.reference.len() as u32, s.thickness);
    let header = OutcomeHeader {
        state: outcome.state.len() as u64,
        extent: outcome.extent,
        handed: outcome.handed.iter().map(row).collect(),
        surfaces: outcome.surfaces.iter().map(counts).collect(),
        frames: outcome.frames.iter().map(frame).collect(),
        pieces: outcome.pieces.len() as u32,
        settled: outcome.settled.iter().map(settled_row).collect::<Result<_, _>>()?,
        ledger: outcome.ledger,
        figures: outcome.figures.iter().take(MAX_DETAILS).cloned().collect(),
        warnings: outcome.warnings.iter().take(MAX_WARNINGS).map(|text| cut(text)).collect(),
    };
    header.check()?;
    let mut slabs = outcome.state.clone();
    for handed in &outcome.handed {
        same("poses of a body", handed.poses.len(), handed.impulses.len())?;
        mesh::put_points(&mut slabs, handed.impulses.as_flattened());
        poses::put(&mut slabs, &handed.poses);
    }
    for surface in &outcome.surfaces {
        mesh::put_u32s(&mut slabs, surface.triangles.as_flattened().iter().copied());
        mesh::put_marks(&mut slabs, surface.reference.as_flattened());
    }
    for frame in &outcome.frames {
        mesh::put_marks(&mut slabs, frame.offsets.as_flattened());
        if !frame.quantity.is_empty() {
            same("values of a quantity", frame.quantity.len(), frame.offsets.len())?;
            mesh::put_marks(&mut slabs, &frame.quantity);
        }
    }
    for piece in &outcome.pieces {
        mesh::put_u32s(&mut slabs, [piece.number, piece.parent, u32::from(piece.frozen)]);
        slabs.extend_from_slice(&piece.born.to_le_bytes());
        slabs.extend_from_slice(&piece.mass.to_le_bytes());
        slabs.extend_from_slice(&piece.area.to_le_bytes());
    }
    outcome.settled.iter().for_each(|piece| mesh::put_solid(&mut slabs, &piece.solid));
    envelope::seal(MessageKind::WindowResult, &header, &slabs)
}

fn settled_row(piece: &SettledPiece) -> Result<SettledRow, WireError> {
    let (vertices, triangles) = mesh::counts(&piece.solid)?;
    let (number, place, mass) = (piece.number, piece.place.into(), piece.mass);
    Ok(SettledRow { number, vertices, triangles, place, mass })
}

/// The state in an outcome's bytes, if they are such.
#[must_use]
pub fn state_of(bytes: &[u8]) -> Option<&[u8]> {
    let (header, slabs) = envelope::open::<OutcomeHeader>(MessageKind::WindowResult, bytes).ok()?;
    slabs.get(..usize::try_from(header.state).ok()?)
}

/// The outcome in these bytes.
///
/// # Errors
/// The first thing wrong with them, with the bound.
pub fn decode_outcome(bytes: &[u8]) -> Result<WindowOutcome, WireError> {
    let (header, slabs) = envelope::open::<OutcomeHeader>(MessageKind::WindowResult, bytes)?;
    header.check()?;
    let mut slabs = Slabs::new(slabs);
    let state = slabs.take("a window's state", header.state as usize, 1)?.to_vec();
    let handed = header.handed.into_iter().map(|row| {
        let impulses = slabs.points("impulses on a body", 2 * row.steps as usize)?;
        let poses = poses::take(&mut slabs, "poses of a body", row.steps as usize)?;
        Ok(Handed { body: row.body, impulses: impulses.as_chunks().0.to_vec(), poses })
    });
    let handed = handed.collect::<Result<_, WireError>>()?;
    let surfaces = header.surfaces.iter().map(|&(triangles, points, thickness)| {
        let corners = slabs.u32s("a surface's triangles", 3 * triangles as usize)?;
        let triangles = corners.as_chunks::<3>().0.to_vec();
        check_corners(&triangles, points)?;
        let reference = floats(&mut slabs, "a surface at rest", 2 * points as usize)?;
        Ok(MovingSurface { triangles, reference: reference.as_chunks().0.to_vec(), thickness })
    });
    let surfaces = surfaces.collect::<Result<Vec<_>, WireError>>()?;
    let mut frames = Vec::with_capacity(header.frames.len());
    for row in header.frames {
        let points = row.points as usize;
        let of = header.surfaces.get(row.surface as usize).map_or(0, |surface| surface.1);
        same("points of a frame", points, of as usize)?;
        let offsets = floats(&mut slabs, "a frame", 3 * points)?.as_chunks().0.to_vec();
        let quantity = match row.quantity {
            true => floats(&mut slabs, "a frame's quantity", points)?,
            false => Vec::new(),
        };
        let (step, surface, origin) = (row.step, row.surface, Vec3::from(row.origin));
        frames.push(SurfaceFrame { step, surface, origin, offsets, quantity });
    }
    let rows = slabs.take("pieces of a sheet", header.pieces as usize, PIECE)?;
    let pieces = rows.as_chunks::<PIECE>().0.iter().map(piece).collect::<Result<_, _>>()?;
    let settled = header.settled.iter().map(|row| {
        let solid = Arc::new(slabs.solid(row.vertices, row.triangles)?);
        Ok(SettledPiece { number: row.number, solid, place: row.place.into(), mass: row.mass })
    });
    let settled = settled.collect::<Result<_, WireError>>()?;
    slabs.end("a window's outcome")?;
    let OutcomeHeader { extent, ledger, figures, warnings, .. } = header;
    Ok(WindowOutcome {
        state,
        extent,
        handed,
        surfaces,
        frames,
        pieces,
        settled,
        ledger,
        figures,
        warnings,
    })
}

impl OutcomeHeader {
    fn check(&self) -> Result<(), WireError> {
        codec::limit("a window's state", self.state, MAX_STATE)?;
        codec::limit("bodies with impulses", self.handed.len() as u64, MAX_PROXIES as u64)?;
        codec::limit("surfaces of a window", self.surfaces.len() as u64, MAX_FRAMES)?;
        codec::limit("frames of a window", self.frames.len() as u64, MAX_FRAMES)?;
        codec::limit("pieces of a sheet", u64::from(self.pieces), MAX_PIECES)?;
        codec::limit("pieces at rest", self.settled.len() as u64, MAX_SETTLED)?;
        for row in &self.settled {
            codec::finite("where a piece is", &row.place)?;
            codec::finite("the mass of a piece", &[row.mass])?;
        }
        codec::limit("figures of a window", self.figures.len() as u64, MAX_DETAILS as u64)?;
        codec::limit("warnings of a window", self.warnings.len() as u64, MAX_WARNINGS as u64)?;
        for &(triangles, points, thickness) in &self.surfaces {
            codec::limit("a surface's triangles", u64::from(triangles), MAX_POINTS)?;
            codec::limit("a surface's points", u64::from(points), MAX_POINTS)?;
            codec::finite("a surface's thickness", &[f64::from(thickness)])?;
        }
        for row in &self.handed {
            codec::limit("steps with impulses", u64::from(row.steps), MAX_WINDOW_STEPS)?;
        }
        let SweptExtent { low, high, speed, spacing } = self.extent;
        codec::finite("where a body is", &[low, high].concat())?;
        codec::finite("how a body moves", &[speed, spacing])?;
        self.frames.iter().try_for_each(|row| codec::finite("a frame's origin", &row.origin))?;
        let values: Vec<f64> = self.figures.iter().map(|figure| figure.value).collect();
        codec::finite("a window's figures", &values)?;
        codec::finite("a window's ledger", &self.ledger.numbers().map(|(_, value)| value))
    }
}

fn same(what: &'static str, have: usize, need: usize) -> Result<(), WireError> {
    if have == need { Ok(()) } else { Err(WireError::Short { what, have, need }) }
}

fn check_corners(triangles: &[[u32; 3]], points: u32) -> Result<(), WireError> {
    let vertices = points as usize;
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&corner| corner >= points) {
            return Err(WireError::Index { triangle, index, vertices });
        }
    }
    Ok(())
}

fn floats(slabs: &mut Slabs<'_>, what: &'static str, count: usize) -> Result<Vec<f32>, WireError> {
    let bytes = slabs.take(what, count, 4)?;
    let all: Vec<f32> = bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    match all.iter().all(|x| x.is_finite()) {
        true => Ok(all),
        false => Err(WireError::NotFinite { what }),
    }
}

fn piece(row: &[u8; PIECE]) -> Result<TornPiece, WireError> {
    let word = |at: usize| u32::from_le_bytes([row[at], row[at + 1], row[at + 2], row[at + 3]]);
    let long = |at: usize| u64::from(word(at)) | u64::from(word(at + 4)) << 32;
    let (mass, area) = (f64::from_bits(long(20)), f64::from_bits(long(28)));
    codec::finite("a piece of a sheet", &[mass, area])?;
    codec::limit("a mark of a piece", u64::from(word(8)), 1)?;
    let (number, parent, frozen) = (word(0), word(4), word(8) == 1);
    Ok(TornPiece { number, parent, born: long(12), mass, area, frozen })
}
