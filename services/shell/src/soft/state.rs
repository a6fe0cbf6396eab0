//! What a soft shell is between two windows, and its bytes.

use super::NAME;
use super::prepared::PreparedWall;
use crate::domain::ShellDomain;
use cullet_continuum::pieces::gone_points;
use cullet_continuum::{PieceRecord, StateReader, StateWriter};
use cullet_model::Refusal;

/// First byte of a state. A new layout takes the next number.
const VERSION: u8 = 1;

/// A soft shell at the end of a step of the world.
#[derive(Clone, Debug)]
pub(super) struct SoftShellState<const N: usize> {
    /// Steps of the world so far.
    pub(super) step: u64,
    pub(super) domain: ShellDomain<f64, N>,
    /// Number of the piece that each point belongs to.
    pub(super) labels: Vec<u32>,
    pub(super) pieces: Vec<PieceRecord>,
}

/// What left a shell with pieces that have become rigid bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RetiredShare {
    /// Of its control points \[kg\].
    pub(super) mass: f64,
    /// What its points stored \[J\].
    pub(super) energy: f64,
}

impl<const N: usize> SoftShellState<N> {
    /// A shell before anything happens.
    pub(super) fn start(prepared: &PreparedWall<N>) -> Self {
        let (mut domain, body) = (prepared.domain.clone(), &prepared.body);
        let origin = body.pose.translation.vector;
        let nodes = domain.mass.len();
        let base = |n: usize| prepared.domain.origin[n] as usize;
        for n in 0..nodes {
            let (first, place) = (domain.surface.nodes[base(n)], prepared.rest[base(n)]);
            domain.velocity[n] = body.velocity + body.spin.cross(&(place - origin));
            let moved = place - first;
            domain.displacement[n] = [moved.x, moved.y, moved.z, 0.0];
        }
        for grip in prepared.grips.iter().rev().filter(|grip| grip.holds(0.0)) {
            for n in (0..nodes).filter(|&n| grip.nodes.binary_search(&(base(n) as u32)).is_ok()) {
                let (place, velocity) = grip.leads(&prepared.rest[base(n)], 0.0);
                let moved = place - domain.surface.nodes[base(n)];
                domain.displacement[n] = [moved.x, moved.y, moved.z, 0.0];
                domain.velocity[n] = velocity;
            }
        }
        let labels = vec![0; domain.points()];
        Self { step: 0, domain, labels, pieces: vec![PieceRecord::default()] }
    }

    /// Takes pieces out that have become rigid bodies; what left with them.
    ///
    /// # Errors
    /// If one of them is not a piece at rest.
    pub(super) fn retire(
        &mut self,
        numbers: &[u32],
        world_step: f64,
    ) -> Result<RetiredShare, Refusal> {
        if numbers.is_empty() {
            return Ok(RetiredShare::default());
        }
        let (mass, energy) = (self.mass(), self.domain.elastic_energy());
        cullet_continuum::retire(&mut self.pieces, numbers, world_step, NAME)?;
        self.domain.remove(&gone_points(&self.labels, &self.pieces));
        let energy = energy - self.domain.elastic_energy();
        Ok(RetiredShare { mass: mass - self.mass(), energy })
    }

    /// Mass of the control points of pieces that are here \[kg\].
    pub(super) fn mass(&self) -> f64 {
        let mass = &self.domain.mass;
        if !self.pieces.iter().any(PieceRecord::is_gone) {
            return mass.iter().sum();
        }
        let here = mass.iter().zip(self.node_pieces());
        here.filter(|(_, piece)| piece.is_some()).map(|(mass, _)| mass).sum()
    }

    /// The piece that is here of each control point; that of dust where it moves nothing else.
    pub(super) fn node_pieces(&self) -> Vec<Option<u32>> {
        let domain = &self.domain;
        let gone = gone_points(&self.labels, &self.pieces);
        let mut pieces = vec![None; domain.mass.len()];
        for dead in [true, false] {
            for p in domain.live().filter(|&p| !gone[p] && domain.state(p).dead == dead) {
                let (nodes, shares) = domain.functions(p);
                let moved = nodes.iter().zip(shares).filter(|(_, share)| **share != 0.0);
                moved.for_each(|(&n, _)| pieces[n as usize] = Some(self.labels[p]));
            }
        }
        pieces
    }

    /// What of it is no number.
    pub(super) fn not_finite(&self) -> Option<&'static str> {
        let moved = self.domain.displacement.iter().flatten();
        if !moved.copied().all(f64::is_finite) {
            return Some("places of a soft shell");
        }
        let fine = self.domain.velocity.iter().flatten().all(|c| c.is_finite());
        (!fine).then_some("velocities of a soft shell")
    }

    /// Its bytes: equal states have equal ones.
    pub(super) fn encode(&self, prepared: &PreparedWall<N>) -> Vec<u8> {
        let mut bytes = StateWriter(vec![VERSION]);
        bytes.number(prepared.fingerprint);
        bytes.number(self.step);
        self.domain.write(&prepared.domain, &mut bytes);
        let is_whole = self.labels.iter().all(|&label| label == 0);
        bytes.0.push(u8::from(!is_whole));
        if !is_whole {
            self.labels.iter().for_each(|&label| bytes.short(label));
        }
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
    /// If they are of another version or shell, are cut short, or hold what no state does.
    pub(super) fn decode(prepared: &PreparedWall<N>, bytes: &[u8]) -> Result<Self, Refusal> {
        let mut reader = StateReader::new(NAME, bytes);
        let version = reader.take(1)?[0];
        if version != VERSION {
            return Err(reader.foreign(&format!("it has the version {version}, not {VERSION}")));
        }
        if reader.number()? != prepared.fingerprint {
            return Err(reader.foreign("it is of another shell"));
        }
        let step = reader.number()?;
        let domain = ShellDomain::read(&prepared.domain, &mut reader)?;
        let mut labels = vec![0; domain.points()];
        if reader.take(1)?[0] != 0 {
            for label in &mut labels {
                *label = reader.short()?;
            }
        }
        let mut pieces = Vec::new();
        for _ in 0..reader.short()? {
            pieces.push(PieceRecord {
                number: reader.short()?,
                parent: reader.short()?,
                born: reader.number()?,
                still: reader.short()?,
            });
        }
        let mut numbers: Vec<u32> = pieces.iter().map(|piece| piece.number).collect();
        numbers.sort_unstable();
        // Each split takes the next number and leaves a point or more behind.
        let most = labels.len() as u32;
        if numbers.windows(2).any(|two| two[0] == two[1]) || numbers.iter().any(|&n| n > most) {
            return Err(reader.foreign("its pieces are not numbered as they came to be"));
        }
        reader.end()?;
        if !labels.iter().all(|label| numbers.binary_search(label).is_ok()) {
            return Err(reader.foreign("it names an unknown piece"));
        }
        let state = Self { step, domain, labels, pieces };
        match state.not_finite() {
            Some(what) => Err(reader.foreign(&format!("{what} are not finite"))),
            None => Ok(state),
        }
    }
}
