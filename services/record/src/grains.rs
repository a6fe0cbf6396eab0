//! Grains of debris in a recording. A grain that flies freely follows to the last bit from where it
//! was: the file has its row rounded, and reading makes it exact again. A grain that lies has none.
//! The digest covers the exact rows of all grains that do not lie for good.

use cullet_geometry::Vec3;
use cullet_proto::recording::Grains;
use cullet_world::{DebrisParticle, FreeFlight};
use std::collections::BTreeMap;

/// Where a grain is, and how fast.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Speck {
    position: Vec3,
    velocity: Vec3,
}

/// Every grain as of its last row, which the writer and the reader keep alike.
#[derive(Clone, Debug, Default)]
pub(super) struct GrainRows {
    free: Option<FreeFlight>,
    known: BTreeMap<u64, Speck>,
    /// How many grains, from the oldest on, lie for good.
    lying: usize,
}

/// A message to write.
pub(super) struct GrainMessage {
    /// What the digest covers.
    pub(super) all: Grains,
    /// What the file gets.
    pub(super) told: Grains,
}

/// The rows that a message of the short form stands for.
pub(super) struct LongForm {
    /// One of each grain that does not lie for good: what the digest covers.
    pub(super) all: Grains,
    /// Those that the file has.
    pub(super) moved: Grains,
}

/// As the metadata record `run` says it.
fn free_flight(meta: &BTreeMap<String, String>) -> Option<FreeFlight> {
    let step: f64 = meta.get("step")?.parse().ok()?;
    let gravity = meta.get("gravity")?.split(' ').map(str::parse::<f64>);
    let gravity: Vec<f64> = gravity.collect::<Result<_, _>>().ok()?;
    let faster = Vec3::from(<[f64; 3]>::try_from(gravity).ok()?) * step;
    Some(FreeFlight { faster, step })
}

impl Speck {
    fn bits(&self) -> [[u64; 3]; 2] {
        [self.position, self.velocity].map(|triple| triple.map(f64::to_bits).into())
    }

    /// Position and velocity to the nearest float.
    fn rounded(&self) -> [[f32; 3]; 2] {
        [self.position, self.velocity].map(|triple| triple.map(|value| value as f32).into())
    }

    fn put(&self, id: u64, rows: &mut Grains) {
        rows.ids.push(id);
        rows.positions.extend(self.position.iter());
        rows.velocities.extend(self.velocity.iter());
    }

    fn put_rounded(&self, id: u64, rows: &mut Grains) {
        let [position, velocity] = self.rounded();
        rows.flying.push(id);
        rows.flown_positions.extend(position);
        rows.flown_velocities.extend(velocity);
    }
}

/// The exact rows of a message.
fn exact(rows: &Grains) -> impl Iterator<Item = (u64, Speck)> {
    let (at, v) = (rows.positions.as_chunks::<3>().0, rows.velocities.as_chunks::<3>().0);
    let specks =
        at.iter().zip(v).map(|(&at, &v)| Speck { position: at.into(), velocity: v.into() });
    rows.ids.iter().copied().zip(specks)
}

impl GrainRows {
    pub(super) fn of(meta: &BTreeMap<String, String>) -> Self {
        Self { free: free_flight(meta), ..Self::default() }
    }

    /// Takes in exact rows.
    pub(super) fn take(&mut self, rows: &Grains) {
        self.known.extend(exact(rows));
    }

    /// Whether all grains lie for good.
    pub(super) fn lie(&self, grains: &[DebrisParticle]) -> bool {
        grains.len() == self.lying
    }

    /// The messages of a step: all of a new grain, and where those that fly are. `grains`: all that
    /// there are, as the world keeps them.
    pub(super) fn tell(
        &mut self,
        step: u64,
        time: f64,
        grains: &[DebrisParticle],
    ) -> Vec<GrainMessage> {
        let (known, lying) = (self.known.len(), self.lying);
        let mut born = Grains { step, time, ..Default::default() };
        for grain in &grains[known..] {
            born.masses.push(grain.mass);
            born.sizes.push(grain.size);
            born.parents.push(u64::from(grain.parent.0));
            put_grain(&mut born, grain);
        }
        let mut moved = Grains { step, time, ..Default::default() };
        // The last row of a grain is that of the step in which it came to rest.
        grains[lying..known].iter().for_each(|grain| put_grain(&mut moved, grain));
        let short = self.short(&moved);
        let down = grains[lying..].iter().take_while(|grain| grain.resting).count();
        self.lying = lying + down;
        let new = GrainMessage { told: born.clone(), all: born };
        let old = GrainMessage { told: short, all: moved };
        let messages: Vec<_> = [new, old].into_iter().filter(|it| !it.all.ids.is_empty()).collect();
        messages.iter().for_each(|it| self.take(&it.all));
        messages
    }

    /// Where a grain is a step after its last row if it flew freely.
    fn flown(&self, last: &Speck) -> Option<Speck> {
        let (position, velocity) = self.free?.after(last.position, last.velocity);
        Some(Speck { position, velocity })
    }

    /// The grains that a message of the short form is about; none of one of the long form.
    fn between(&self, short: &Grains) -> impl Iterator<Item = (&u64, &Speck)> {
        let range = short.first.zip(short.last).filter(|(first, last)| first <= last);
        range.into_iter().flat_map(|(first, last)| self.known.range(first..=last))
    }

    /// The short form of the rows of all grains that do not lie for good; the rows themselves where
    /// none of them can be left out or rounded.
    fn short(&self, rows: &Grains) -> Grains {
        let (first, last) = (rows.ids.first().copied(), rows.ids.last().copied());
        let (step, time) = (rows.step, rows.time);
        let mut short = Grains { step, time, first, last, ..Default::default() };
        let before: Vec<(&u64, &Speck)> = self.between(&short).collect();
        if !before.iter().map(|(id, _)| *id).eq(&rows.ids) {
            return rows.clone();
        }
        for ((id, now), (_, last)) in exact(rows).zip(before) {
            if now.bits() == last.bits() {
                continue;
            }
            match self.flown(last) {
                Some(flown) if flown.bits() == now.bits() => now.put_rounded(id, &mut short),
                _ => now.put(id, &mut short),
            }
        }
        if short.ids.len() < rows.ids.len() { short } else { rows.clone() }
    }

    /// What a message of the short form stands for; nothing of one whose rows are all exact.
    pub(super) fn long(&self, short: &Grains) -> Option<LongForm> {
        short.first.zip(short.last)?;
        let mut told: Vec<(u64, Speck)> = exact(short).chain(self.exact_again(short)).collect();
        told.sort_by_key(|(id, _)| *id);
        let rows = || Grains { step: short.step, time: short.time, ..Default::default() };
        let (mut all, mut moved) = (rows(), rows());
        let mut last = self.between(short).peekable();
        for (id, now) in &told {
            while let Some((lying, speck)) = last.next_if(|(other, _)| *other < id) {
                speck.put(*lying, &mut all);
            }
            last.next_if(|(other, _)| *other == id);
            now.put(*id, &mut all);
            now.put(*id, &mut moved);
        }
        last.for_each(|(lying, speck)| speck.put(*lying, &mut all));
        Some(LongForm { all, moved })
    }

    /// The rounded rows made exact. A row that does not follow from the last one that is known, as
    /// where a part of the file is lost, stays rounded.
    fn exact_again<'a>(&'a self, short: &'a Grains) -> impl Iterator<Item = (u64, Speck)> + 'a {
        let at = short.flown_positions.as_chunks::<3>().0;
        let rows = at.iter().zip(short.flown_velocities.as_chunks::<3>().0);
        short.flying.iter().zip(rows).map(|(&id, (&position, &velocity))| {
            let exact = self.known.get(&id).and_then(|last| self.flown(last));
            let exact = exact.filter(|exact| exact.rounded() == [position, velocity]);
            let rounded = || {
                let [position, velocity] =
                    [position, velocity].map(|row| row.map(f64::from).into());
                Speck { position, velocity }
            };
            (id, exact.unwrap_or_else(rounded))
        })
    }
}

fn put_grain(rows: &mut Grains, grain: &DebrisParticle) {
    let (position, velocity) = (grain.position, grain.velocity);
    Speck { position, velocity }.put(grain.id, rows);
}

#[cfg(test)]
mod tests;
