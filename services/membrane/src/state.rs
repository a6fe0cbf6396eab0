//! What a sheet is between two windows, and its bytes.

use crate::law::BondMemory;
use crate::prepared::PreparedMembrane;
use cullet_continuum::{PieceRecord, StateReader, StateWriter};
use cullet_geometry::Vec3;
use cullet_model::{MembraneLaw, Refusal, SheetPlace};

/// First byte of a state. A new layout takes the next number.
const VERSION: u8 = 1;

/// A sheet at the end of a step of the world.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetState {
    /// Steps of the world so far.
    pub step: u64,
    /// \[m\].
    pub places: Vec<Vec3>,
    /// \[m/s\].
    pub velocities: Vec<Vec3>,
    /// θ of each point, one quantity after the other; empty where nothing diffuses.
    pub theta: Vec<f64>,
    /// What each point has been exposed to, likewise.
    pub exposure: Vec<f64>,
    /// d of each bond.
    pub damage: Vec<f64>,
    /// p of each bond of a foil; empty otherwise.
    pub plastic: Vec<f64>,
    /// α_p, likewise.
    pub flowed: Vec<f64>,
    /// Number of the piece that each point belongs to.
    pub labels: Vec<u32>,
    pub(crate) pieces: Vec<PieceRecord>,
}

impl SheetState {
    /// A sheet before anything happens.
    #[must_use]
    pub fn start(prepared: &PreparedMembrane) -> Self {
        let sheet = prepared.sheet();
        let count = prepared.points.places.len();
        let place = |&[x, y]: &SheetPlace| (sheet.pose * nalgebra::Point3::new(x, y, 0.0)).coords;
        let mut places: Vec<Vec3> = prepared.points.places.iter().map(place).collect();
        let mut velocities = vec![sheet.velocity; count];
        for grip in prepared.grips.iter().rev().filter(|grip| grip.holds(0.0)) {
            let (moved, velocity) = grip.at(0.0);
            for &i in &grip.points {
                places[i as usize] = place(&prepared.points.places[i as usize]) + moved;
                velocities[i as usize] = velocity;
            }
        }
        let bonds = prepared.bonds.ends.len();
        let flows = if sheet.material.law == MembraneLaw::Foil { bonds } else { 0 };
        let damage = prepared.bonds.cut.iter().map(|&cut| f64::from(u8::from(cut))).collect();
        let all = sheet.diffusion.all.iter();
        let theta: Vec<f64> = all.flat_map(|what| std::iter::repeat_n(what.start, count)).collect();
        Self {
            step: 0,
            places,
            velocities,
            exposure: vec![0.0; theta.len()],
            theta,
            damage,
            plastic: vec![0.0; flows],
            flowed: vec![0.0; flows],
            labels: vec![0; count],
            pieces: vec![PieceRecord::default()],
        }
    }

    /// What a bond remembers.
    #[inline(always)]
    #[must_use]
    pub fn memory(&self, b: usize) -> BondMemory {
        let of = |all: &[f64]| all.get(b).copied().unwrap_or(0.0);
        BondMemory { damage: self.damage[b], plastic: of(&self.plastic), flowed: of(&self.flowed) }
    }

    /// θ of a quantity at each point.
    #[must_use]
    pub fn theta_of(&self, quantity: usize) -> &[f64] {
        let count = self.places.len();
        &self.theta[quantity * count..(quantity + 1) * count]
    }

    /// θ of each quantity at a point.
    pub fn thetas_at(&self, point: usize) -> impl Iterator<Item = f64> + '_ {
        self.theta.iter().skip(point).step_by(self.places.len().max(1)).copied()
    }

    /// Whether all numbers are numbers.
    pub(crate) fn not_finite(&self) -> Option<&'static str> {
        let vectors = |all: &[Vec3]| all.iter().flatten().all(|c| c.is_finite());
        if !vectors(&self.places) {
            return Some("places of a sheet");
        }
        if !vectors(&self.velocities) {
            return Some("velocities of a sheet");
        }
        let fine = self.theta.iter().chain(&self.exposure).all(|c| c.is_finite());
        (!fine).then_some("the quantity that diffuses")
    }

    /// Its bytes: equal states have equal ones.
    #[must_use]
    pub fn encode(&self, prepared: &PreparedMembrane) -> Vec<u8> {
        let mut bytes = StateWriter(vec![VERSION]);
        bytes.number(prepared.fingerprint);
        bytes.number(self.step);
        self.places.iter().chain(&self.velocities).flatten().for_each(|c| bytes.real(*c));
        self.theta.iter().chain(&self.exposure).for_each(|c| bytes.real(*c));
        let mut marks = Vec::new();
        let mut values = StateWriter::default();
        let mut slot = 0;
        for_each_bond(prepared, |b, _| {
            let memory = self.memory(b);
            let touched = memory != fresh(prepared, b);
            if slot % 8 == 0 {
                marks.push(0u8);
            }
            if touched {
                marks[slot / 8] |= 1 << (slot % 8);
                values.real(memory.damage);
                if !self.plastic.is_empty() {
                    values.real(memory.plastic);
                    values.real(memory.flowed);
                }
            }
            slot += 1;
        });
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
    /// If they are of another version or sheet, are cut short, or hold what no state does.
    pub fn decode(prepared: &PreparedMembrane, bytes: &[u8]) -> Result<Self, Refusal> {
        let mut reader = StateReader::new(crate::family::NAME, bytes);
        let version = reader.take(1)?[0];
        if version != VERSION {
            return Err(reader.foreign(&format!("it has the version {version}, not {VERSION}")));
        }
        if reader.number()? != prepared.fingerprint {
            return Err(reader.foreign("it is of another sheet"));
        }
        let mut state = Self::start(prepared);
        state.step = reader.number()?;
        for value in state.places.iter_mut().chain(&mut state.velocities).flatten() {
            *value = reader.real()?;
        }
        for value in state.theta.iter_mut().chain(&mut state.exposure) {
            *value = reader.real()?;
        }
        let mut bonds = Vec::new();
        for_each_bond(prepared, |b, twin| bonds.push((b, twin)));
        let marks = reader.take(bonds.len().div_ceil(8))?;
        for (slot, (b, twin)) in bonds.into_iter().enumerate() {
            if marks[slot / 8] >> (slot % 8) & 1 == 0 {
                continue;
            }
            let damage = reader.real()?;
            if !(0.0..=1.0).contains(&damage) {
                return Err(reader.foreign(&format!("a damage is {damage}")));
            }
            [state.damage[b], state.damage[twin]] = [damage; 2];
            if !state.plastic.is_empty() {
                [state.plastic[b], state.plastic[twin]] = [reader.real()?; 2];
                let flowed = reader.real()?;
                if !state.plastic[b].is_finite() || !flowed.is_finite() || flowed < 0.0 {
                    return Err(reader.foreign(&format!("a plastic stretch is {flowed}")));
                }
                [state.flowed[b], state.flowed[twin]] = [flowed; 2];
            }
        }
        for label in &mut state.labels {
            *label = reader.short()?;
        }
        state.pieces =
            (0..reader.short()?).map(|_| piece(&mut reader)).collect::<Result<_, _>>()?;
        let mut numbers: Vec<u32> = state.pieces.iter().map(|piece| piece.number).collect();
        numbers.sort_unstable();
        // Each split takes the next number and leaves a point or more behind.
        let most = prepared.points.places.len() as u32;
        if numbers.windows(2).any(|two| two[0] == two[1]) || numbers.iter().any(|&n| n > most) {
            return Err(reader.foreign("its pieces are not numbered as they came to be"));
        }
        let known = |label: &u32| numbers.binary_search(label).is_ok();
        reader.end()?;
        if !state.labels.iter().all(known) {
            return Err(reader.foreign("it names an unknown piece"));
        }
        match state.not_finite() {
            Some(what) => Err(reader.foreign(&format!("{what} are not finite"))),
            None => Ok(state),
        }
    }
}

/// What a bond remembers before anything happens.
fn fresh(prepared: &PreparedMembrane, b: usize) -> BondMemory {
    BondMemory { damage: f64::from(u8::from(prepared.bonds.cut[b])), ..BondMemory::default() }
}

/// Each bond once, with its twin.
fn for_each_bond(prepared: &PreparedMembrane, mut f: impl FnMut(usize, usize)) {
    for i in 0..prepared.points.places.len() {
        for b in prepared.bonds.of(i).filter(|&b| prepared.bonds.ends[b] as usize > i) {
            f(b, prepared.bonds.twins[b] as usize);
        }
    }
}

fn piece(reader: &mut StateReader<'_>) -> Result<PieceRecord, Refusal> {
    Ok(PieceRecord {
        number: reader.short()?,
        parent: reader.short()?,
        born: reader.number()?,
        still: reader.short()?,
    })
}
