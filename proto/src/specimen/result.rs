//! What came out of a specimen: a header, then the samples as slabs of little-endian numbers.

use crate::bounds::{MAX_PROBES, MAX_SAMPLES};
use crate::codec::{self, WireError};
use crate::envelope::{self, MessageKind};
use crate::mesh::Slabs;
use cullet_specimen::{Ending, Frame, SpecimenOutcome};
use serde::{Deserialize, Serialize};

/// Most numbers of all frames together.
const MAX_FRAME_NUMBERS: u64 = 1 << 28;

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

/// What came out of a specimen, and what it cost.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecimenResult {
    /// What came out.
    pub outcome: SpecimenOutcome,
    /// What it cost.
    pub price: Price,
}

#[derive(Serialize, Deserialize)]
struct ResultHeader {
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
    /// A run that came to nothing, and cost nothing.
    #[must_use]
    pub fn ended(ending: Ending) -> Self {
        Self { outcome: SpecimenOutcome::ended(ending), price: Price::default() }
    }

    /// The bytes.
    ///
    /// # Errors
    /// The limit of the wire that it breaks.
    pub fn encode(&self) -> Result<Vec<u8>, WireError> {
        let out = &self.outcome;
        let frames = out.frames.iter().map(|f| (f.time, f.points.len() as u32)).collect();
        let header = ResultHeader {
            ending: out.ending.clone(),
            step: out.step,
            steps: out.steps,
            points: out.points,
            strength_ratio: out.strength_ratio,
            price: self.price,
            pieces: out.pieces.len() as u32,
            times: out.times.len() as u32,
            rows: out.rows.len() as u32,
            frames,
        };
        let mut bulk = Vec::new();
        let numbers = out.pieces.iter().chain(&out.times).chain(out.rows.iter().flatten());
        numbers.for_each(|x| bulk.extend_from_slice(&x.to_le_bytes()));
        let points = out.frames.iter().flat_map(|frame| frame.points.iter().flatten());
        points.for_each(|x| bulk.extend_from_slice(&x.to_le_bytes()));
        envelope::seal(MessageKind::SpecimenResult, &header, &bulk)
    }

    /// The result in these bytes.
    ///
    /// # Errors
    /// The first thing wrong with them, with the bound.
    pub fn decode(bytes: &[u8]) -> Result<Self, WireError> {
        let (header, bulk) = envelope::open::<ResultHeader>(MessageKind::SpecimenResult, bytes)?;
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
        let ResultHeader { ending, step, steps, points, strength_ratio, price, .. } = header;
        let outcome = SpecimenOutcome {
            ending,
            step,
            steps,
            points,
            strength_ratio,
            pieces,
            times,
            rows,
            frames,
        };
        Ok(Self { outcome, price })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_comes_back_as_it_went_or_says_what_is_missing() -> Result<(), WireError> {
        let frame = Frame { time: 0.5, points: vec![[1.0, 2.0, 3.0, 4.0]; 3] };
        let outcome = SpecimenOutcome {
            times: vec![0.0, 1.0],
            rows: vec![vec![1.0, 2.0], vec![f64::INFINITY, -1.0], vec![0.0; 2]],
            pieces: vec![1.0],
            frames: vec![frame],
            ..SpecimenOutcome::ended(Ending::Unstable("why".into()))
        };
        let price = Price { wall: 1.0, cpu: 2.0, peak: 3 };
        let result = SpecimenResult { outcome, price };
        let bytes = result.encode()?;
        assert_eq!(SpecimenResult::decode(&bytes)?, result);
        let short = SpecimenResult::decode(&bytes[..bytes.len() - 1]);
        assert!(matches!(short, Err(WireError::Short { what: "a result's frames", .. })));
        Ok(())
    }
}
