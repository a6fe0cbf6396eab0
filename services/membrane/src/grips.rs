//! What holds parts of a sheet: prescribed paths, and the strip around them that does not break.

use cullet_continuum::GripPath;
use cullet_continuum::bytes::held;
use cullet_geometry::Vec3;
use cullet_model::{Refusal, SheetGrip, SheetPlace};

/// No bond breaks within this many horizons of a held point: a clamp concentrates stress, and the
/// sheet would tear along it.
const GUARD: f64 = 2.0;
/// A point that nothing holds.
pub(crate) const FREE: u32 = u32::MAX;

/// A grip and the points that it holds.
#[derive(Clone, Debug)]
pub(crate) struct GrippedPoints {
    /// Rising.
    pub(crate) points: Vec<u32>,
    /// Points near enough that their bonds do not break.
    guarded: Vec<u32>,
    path: GripPath,
}

impl GrippedPoints {
    /// Memory that it takes \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        held(&self.points) + held(&self.guarded)
    }

    /// # Errors
    ///
    /// If a grip holds no point or its path does not run forwards.
    pub(crate) fn of_all(
        grips: &[SheetGrip],
        places: &[SheetPlace],
        horizon: f64,
    ) -> Result<Vec<Self>, Refusal> {
        let of = |(k, grip): (usize, &SheetGrip)| Self::new(grip, k + 1, places, horizon);
        grips.iter().enumerate().map(of).collect()
    }

    fn new(
        grip: &SheetGrip,
        number: usize,
        places: &[SheetPlace],
        horizon: f64,
    ) -> Result<Self, Refusal> {
        let all = 0..places.len() as u32;
        let points: Vec<u32> =
            all.clone().filter(|&i| grip.region.has(places[i as usize])).collect();
        if points.is_empty() {
            return Err(Refusal::Idle { what: "grip", number });
        }
        let path = GripPath::new(&grip.path, grip.until, number, crate::family::NAME)?;
        let reach = GUARD * horizon;
        let grid_points: Vec<SheetPlace> = points.iter().map(|&i| places[i as usize]).collect();
        let grid = crate::cells::PlaneGrid::new(&grid_points, reach);
        let near = |&i: &u32| {
            let p = places[i as usize];
            let mut found = false;
            grid.around(p, reach, |k| {
                let q = grid_points[k as usize];
                let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
                found |= dx * dx + dy * dy <= reach * reach;
            });
            found
        };
        let guarded = all.filter(near).collect();
        Ok(Self { points, guarded, path })
    }

    /// Whether the strip around it that does not break reaches a place.
    pub(crate) fn guards(&self, place: SheetPlace, places: &[SheetPlace], spacing: f64) -> bool {
        self.guarded.iter().any(|&i| {
            let [x, y] = places[i as usize];
            (x - place[0]).abs() < 0.5 * spacing && (y - place[1]).abs() < 0.5 * spacing
        })
    }

    /// Whether a place is in the strip or within a horizon \[m\] of it.
    pub(crate) fn is_next_to(
        &self,
        place: SheetPlace,
        places: &[SheetPlace],
        horizon: f64,
    ) -> bool {
        let reach = (GUARD + 1.0) * horizon;
        self.points.iter().any(|&i| {
            let [x, y] = places[i as usize];
            let (dx, dy) = (x - place[0], y - place[1]);
            dx * dx + dy * dy <= reach * reach
        })
    }

    /// Whether it holds in a step of the world that begins at this time \[s\].
    pub(crate) fn holds(&self, time: f64) -> bool {
        self.path.holds(time)
    }

    /// How far \[m\] it has moved at a time \[s\], and how fast it moves just after that \[m/s\].
    pub(crate) fn at(&self, time: f64) -> (Vec3, Vec3) {
        self.path.at(time)
    }
}

/// Which grip holds each point, and which bonds may break, in one step of the world.
#[derive(Clone, Debug, Default)]
pub(crate) struct GripState {
    /// Number of the first grip that holds each point, or [`FREE`].
    pub(crate) holders: Vec<u32>,
    /// Whether bonds of a point may not break.
    pub(crate) guarded: Vec<bool>,
}

impl GripState {
    /// What holds at this time \[s\].
    pub(crate) fn update(&mut self, grips: &[GrippedPoints], count: usize, time: f64) {
        self.holders.clear();
        self.holders.resize(count, FREE);
        self.guarded.clear();
        self.guarded.resize(count, false);
        for (number, grip) in grips.iter().enumerate().rev().filter(|(_, grip)| grip.holds(time)) {
            grip.points.iter().for_each(|&i| self.holders[i as usize] = number as u32);
            grip.guarded.iter().for_each(|&i| self.guarded[i as usize] = true);
        }
    }
}
