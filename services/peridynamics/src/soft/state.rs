//! What a soft solid is between two windows, and its bytes.

use super::prepared::PreparedSoftSolid;
use crate::PeridynamicDomain;
use crate::bonds::BondSlot;
use crate::domain::MaterialPoint;
use cullet_continuum::{PieceRecord, StateReader, StateWriter};
use cullet_geometry::Vec3;
use cullet_model::Refusal;
use nalgebra::Point3;

/// First byte of a state. A new layout takes the next number.
const VERSION: u8 = 1;

/// A soft solid at the end of a step of the world.
#[derive(Clone, Debug)]
pub struct SoftSolidState {
    /// Steps of the world so far.
    pub step: u64,
    /// Places, velocities, and what points and bonds remember.
    pub domain: PeridynamicDomain,
    /// Number of the piece that each point belongs to.
    pub labels: Vec<u32>,
    pub(super) pieces: Vec<PieceRecord>,
}

/// What a bond remembers: k, and e_p at either end.
type SolidBondMemory = [f32; 3];

impl SoftSolidState {
    /// A body before anything happens.
    #[must_use]
    pub fn start(prepared: &PreparedSoftSolid) -> Self {
        let (body, mut domain) = (prepared.body(), prepared.domain.clone());
        let centre = body.pose.translation.vector;
        domain.places =
            prepared.rest.iter().map(|x| (body.pose * Point3::from(*x)).coords).collect();
        domain.velocities = (domain.places.iter())
            .map(|x| body.velocity + body.spin.cross(&(x - centre)))
            .collect();
        for grip in prepared.grips.iter().rev().filter(|grip| grip.holds(0.0)) {
            for (k, &i) in grip.points.iter().enumerate() {
                let (place, velocity) = grip.leads(k, 0.0);
                domain.places[i as usize] = place;
                domain.velocities[i as usize] = velocity;
            }
        }
        let labels = vec![0; domain.places.len()];
        domain.move_apart(&labels);
        Self { step: 0, domain, labels, pieces: vec![PieceRecord::default()] }
    }

    /// Whether all numbers are numbers.
    pub(super) fn not_finite(&self) -> Option<&'static str> {
        let vectors = |all: &[Vec3]| all.iter().flatten().all(|c| c.is_finite());
        if !vectors(&self.domain.places) {
            return Some("places of a soft solid");
        }
        (!vectors(&self.domain.velocities)).then_some("velocities of a soft solid")
    }

    /// Its bytes: equal states have equal ones.
    #[must_use]
    pub fn encode(&self, prepared: &PreparedSoftSolid) -> Vec<u8> {
        let mut bytes = StateWriter(vec![VERSION]);
        bytes.number(prepared.fingerprint);
        bytes.number(self.step);
        let domain = &self.domain;
        domain.places.iter().chain(&domain.velocities).flatten().for_each(|c| bytes.real(*c));
        for state in &domain.states {
            let MaterialPoint { mean, deviation, plastic, ductile, damage } = *state;
            let all = [mean, deviation, plastic, ductile, damage];
            all.iter().for_each(|c| bytes.real(*c));
        }
        let (mut marks, mut values, mut slot) = (Vec::new(), StateWriter::default(), 0);
        for p in 0..domain.places.len() {
            for bond in domain.bonds.of(p).filter(|bond| bond.end > p) {
                if slot % 8 == 0 {
                    marks.push(0u8);
                }
                let now = memory(domain, bond);
                if now.map(f32::to_bits) != memory(&prepared.domain, bond).map(f32::to_bits) {
                    marks[slot / 8] |= 1 << (slot % 8);
                    let count = if domain.flowed[0].is_empty() { 1 } else { 3 };
                    now[..count].iter().for_each(|c| values.short(c.to_bits()));
                }
                slot += 1;
            }
        }
        bytes.0.extend(marks);
        bytes.0.extend(values.0);
        self.labels.iter().for_each(|&label| bytes.short(label));
        bytes.short(self.pieces.len() as u32);
        for piece in &self.pieces {
            bytes.short(piece.number);
            bytes.short(piece.parent);
            bytes.number(piece.born);
            bytes.short(piece.still);
        }
        bytes.0
    }

    /// The state that bytes hold.
    ///
    /// # Errors
    ///
    /// If they are of another version or body, are cut short, or hold what no state does.
    pub fn decode(prepared: &PreparedSoftSolid, bytes: &[u8]) -> Result<Self, Refusal> {
        let mut reader = StateReader::new(super::NAME, bytes);
        let version = reader.take(1)?[0];
        if version != VERSION {
            return Err(reader.foreign(&format!("it has the version {version}, not {VERSION}")));
        }
        if reader.number()? != prepared.fingerprint {
            return Err(reader.foreign("it is of another body"));
        }
        let mut state = Self::start(prepared);
        state.step = reader.number()?;
        let domain = &mut state.domain;
        for value in domain.places.iter_mut().chain(&mut domain.velocities).flatten() {
            *value = reader.real()?;
        }
        for point in &mut domain.states {
            let mut read = [0.0; 5];
            for value in &mut read {
                *value = reader.real()?;
            }
            let [mean, deviation, plastic, ductile, damage] = read;
            if !read.iter().all(|c| c.is_finite()) || deviation < 0.0 || plastic < 0.0 {
                return Err(reader.foreign("a point remembers what none does"));
            }
            *point = MaterialPoint { mean, deviation, plastic, ductile, damage };
        }
        read_bonds(domain, &mut reader)?;
        for label in &mut state.labels {
            *label = reader.short()?;
        }
        state.pieces =
            (0..reader.short()?).map(|_| piece(&mut reader)).collect::<Result<_, _>>()?;
        reader.end()?;
        let mut numbers: Vec<u32> = state.pieces.iter().map(|piece| piece.number).collect();
        numbers.sort_unstable();
        // Each split takes the next number and leaves a point or more behind.
        let most = state.labels.len() as u32;
        if numbers.windows(2).any(|two| two[0] == two[1]) || numbers.iter().any(|&n| n > most) {
            return Err(reader.foreign("its pieces are not numbered as they came to be"));
        }
        if !state.labels.iter().all(|label| numbers.binary_search(label).is_ok()) {
            return Err(reader.foreign("it names an unknown piece"));
        }
        if let Some(what) = state.not_finite() {
            return Err(reader.foreign(&format!("{what} are not finite")));
        }
        state.domain.move_apart(&state.labels);
        Ok(state)
    }
}

/// What a bond remembers.
fn memory(domain: &PeridynamicDomain, bond: BondSlot) -> SolidBondMemory {
    let of = |list: &[cullet_simd::Lanes<f32>], none| match list.is_empty() {
        true => none,
        false => list[bond.group].0[bond.lane],
    };
    [of(&domain.left, 1.0), of(&domain.flowed[0], 0.0), of(&domain.flowed[1], 0.0)]
}

/// Reads what bonds remember that is other than at the start.
fn read_bonds(domain: &mut PeridynamicDomain, reader: &mut StateReader<'_>) -> Result<(), Refusal> {
    let slots = (domain.bonds.count() / 2) as usize;
    let marks = reader.take(slots.div_ceil(8))?;
    let flows = !domain.flowed[0].is_empty();
    let mut slot = 0;
    for p in 0..domain.places.len() {
        let bonds: Vec<BondSlot> = domain.bonds.of(p).filter(|bond| bond.end > p).collect();
        for bond in bonds {
            let marked = marks[slot / 8] >> (slot % 8) & 1 == 1;
            slot += 1;
            if !marked {
                continue;
            }
            let left = f32::from_bits(reader.short()?);
            if !(0.0..=1.0).contains(&left) || domain.left.is_empty() {
                return Err(reader.foreign(&format!("of a bond {left} is left")));
            }
            let Some(twin) = domain.bonds.find(bond.end, p) else {
                return Err(reader.foreign("a bond has one end"));
            };
            domain.left[bond.group].0[bond.lane] = left;
            domain.left[twin.group].0[twin.lane] = left;
            if flows {
                let [own, back] = [reader.short()?, reader.short()?].map(f32::from_bits);
                if !own.is_finite() || !back.is_finite() {
                    return Err(reader.foreign("a plastic extension is not finite"));
                }
                domain.flowed[0][bond.group].0[bond.lane] = own;
                domain.flowed[1][twin.group].0[twin.lane] = own;
                domain.flowed[1][bond.group].0[bond.lane] = back;
                domain.flowed[0][twin.group].0[twin.lane] = back;
            }
        }
    }
    Ok(())
}

fn piece(reader: &mut StateReader<'_>) -> Result<PieceRecord, Refusal> {
    Ok(PieceRecord {
        number: reader.short()?,
        parent: reader.short()?,
        born: reader.number()?,
        still: reader.short()?,
    })
}
