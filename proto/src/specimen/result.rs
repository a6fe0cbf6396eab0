//! What came out of a specimen: a header, then the samples as slabs of little-endian numbers.

use super::{MAX_PROBES, MAX_SAMPLES};
use crate::codec::{self, WireError};
use crate::envelope::{self, Kind};
use crate::mesh::Slabs;
use serde::{Deserialize, Serialize};

/// Most numbers of all frames together.
const MAX_FRAME_NUMBERS: u64 = 1 << 28;

/// How a run ended. Each is a result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Ending {
    /// At its end.
    Ok,
    /// Energy appeared from nowhere.
    Unstable(String),
    /// A number stopped being one.
    NotFinite(String),
    /// It was not for this solver.
    Refused(String),
    /// The program failed, not the physics: it did not start, panicked or died.
    Crashed(String),
    /// It took too long.
    Timeout(String),
    /// The body could not be made.
    Geometry(String),
}

/// All points at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// When \[s\].
    pub time: f64,
    /// Place \[m\] and colouring number of each.
    pub points: Vec<[f32; 4]>,
}

/// What it cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Price {
    /// Wall time of the solve \[s\].
    pub wall: f64,
    /// Processor time of the process \[s\].
    pub cpu: f64,
    /// Most memory of the process \[bytes\].
    pub peak: u64,
}

/// What came out of a specimen.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecimenResult {
    /// How it ended.
    pub ending: Ending,
    /// Time step \[s\].
    pub step: f64,
    /// Steps taken.
    pub steps: u64,
    /// Points.
    pub points: u64,
    /// Stress at which cracks grow over σ_f \[1\].
    pub strength_ratio: f64,
    /// What it cost.
    pub price: Price,
    /// Shares of the body that its pieces have \[1\].
    pub pieces: Vec<f64>,
    /// Times of the samples \[s\].
    pub times: Vec<f64>,
    /// A row for each probe.
    pub rows: Vec<Vec<f64>>,
    /// Pictures.
    pub frames: Vec<Frame>,
}

#[derive(Serialize, Deserialize)]
struct Header {
    ending: Ending,
    step: f64,
    steps: u64,
    points: u64,
    strength_ratio: f64,
    price: Price,
    pieces: u32,
    times: u32,
    rows: u32,
    frames: Vec<(f64, u32)>,
}

impl SpecimenResult {
    /// A run that came to nothing.
    #[must_use]
    pub fn ended(ending: Ending) -> Self {
        Self {
            ending,
            step: 0.0,
            steps: 0,
            points: 0,
            strength_ratio: 1.0,
            price: Price::default(),
            pieces: Vec::new(),
            times: Vec::new(),
            rows: Vec::new(),
            frames: Vec::new(),
        }
    }

    /// The bytes.
    ///
    /// # Errors
    /// The limit of the wire that it breaks.
    pub fn encode(&self) -> Result<Vec<u8>, WireError> {
        let frames = self.frames.iter().map(|f| (f.time, f.points.len() as u32)).collect();
        let header = Header {
            ending: self.ending.clone(),
            step: self.step,
            steps: self.steps,
            points: self.points,
            strength_ratio: self.strength_ratio,
            price: self.price,
            pieces: self.pieces.len() as u32,
            times: self.times.len() as u32,
            rows: self.rows.len() as u32,
            frames,
        };
        let mut bulk = Vec::new();
        let numbers = self.pieces.iter().chain(&self.times).chain(self.rows.iter().flatten());
        numbers.for_each(|x| bulk.extend_from_slice(&x.to_le_bytes()));
        let points = self.frames.iter().flat_map(|frame| frame.points.iter().flatten());
        points.for_each(|x| bulk.extend_from_slice(&x.to_le_bytes()));
        envelope::seal(Kind::SpecimenResult, &header, &bulk)
    }

    /// The result in these bytes.
    ///
    /// # Errors
    /// The first thing wrong with them, with the bound.
    pub fn decode(bytes: &[u8]) -> Result<Self, WireError> {
        let (header, bulk) = envelope::open::<Header>(Kind::SpecimenResult, bytes)?;
        codec::limit("a result's rows", u64::from(header.rows), MAX_PROBES)?;
        codec::limit("a result's samples", u64::from(header.times), 2 * MAX_SAMPLES)?;
        let all: u64 = header.frames.iter().map(|frame| 4 * u64::from(frame.1)).sum();
        codec::limit("the numbers of a result's frames", all, MAX_FRAME_NUMBERS)?;
        let mut slabs = Slabs::new(bulk);
        let mut row = |count: u32| -> Result<Vec<f64>, WireError> {
            let bytes = slabs.take("a result's samples", count as usize, 8)?;
            Ok(bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect())
        };
        let (pieces, times) = (row(header.pieces)?, row(header.times)?);
        let rows = (0..header.rows).map(|_| row(header.times)).collect::<Result<_, _>>()?;
        let mut frames = Vec::new();
        for (time, count) in header.frames {
            let bytes = slabs.take("a result's frames", count as usize, 16)?;
            let numbers: Vec<f32> =
                bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
            frames.push(Frame { time, points: numbers.as_chunks::<4>().0.to_vec() });
        }
        slabs.end("a result")?;
        let Header { ending, step, steps, points, strength_ratio, price, .. } = header;
        let (ending, price) = (ending, price);
        Ok(Self { ending, step, steps, points, strength_ratio, price, pieces, times, rows, frames })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_comes_back_as_it_went_or_says_what_is_missing() -> Result<(), WireError> {
        let frame = Frame { time: 0.5, points: vec![[1.0, 2.0, 3.0, 4.0]; 3] };
        let result = SpecimenResult {
            times: vec![0.0, 1.0],
            rows: vec![vec![1.0, 2.0], vec![f64::INFINITY, -1.0], vec![0.0; 2]],
            pieces: vec![1.0],
            frames: vec![frame],
            ..SpecimenResult::ended(Ending::Unstable("why".into()))
        };
        let bytes = result.encode()?;
        assert_eq!(SpecimenResult::decode(&bytes)?, result);
        let short = SpecimenResult::decode(&bytes[..bytes.len() - 1]);
        assert!(matches!(short, Err(WireError::Short { what: "a result's frames", .. })));
        Ok(())
    }
}
