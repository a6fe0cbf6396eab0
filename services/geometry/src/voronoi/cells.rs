//! Sites in a box, their cells and the places of corners.

use super::grid::SiteGrid;
use super::plane::{ClipPlane, meet};
use crate::math::Vec3;

/// The names of the walls of the box are the last six site numbers: low x, high x, low y, ….
pub const WALL: u32 = u32::MAX - 5;

/// More sites than this would run into the names of the walls, and out of memory first.
pub const MAX_SITES: usize = 1 << 28;

/// The four generators of a corner, ascending: site numbers, then walls (`WALL + 0..6`).
pub type Key = [u32; 4];

/// Why sites have no diagram.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum VoronoiError {
    /// The box is empty or not finite.
    #[error("the box has no volume along axis {axis}: {low:.3e} to {high:.3e}")]
    Box {
        /// 0, 1, 2 for x, y, z.
        axis: usize,
        /// Its lower bound \[m\].
        low: f64,
        /// Its upper bound \[m\].
        high: f64,
    },
    /// No site, or more than can be numbered.
    #[error("{count} sites; at least 1 and at most {MAX_SITES} are allowed")]
    Count {
        /// How many came.
        count: usize,
    },
    /// A site is not strictly inside the box.
    #[error("site {site} is not strictly inside the box")]
    Outside {
        /// The site concerned.
        site: usize,
    },
    /// Five generators meet at one point, or two sites coincide.
    #[error("the cell of site {site} is in special position: jitter the sites")]
    Degenerate {
        /// Whose cell was being cut.
        site: usize,
    },
}

/// A face of a cell: what lies behind it, and its corners counter-clockwise seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// A site number, or `WALL + k` for a wall of the box.
    pub neighbour: u32,
    /// The corners, in order.
    pub corners: Vec<Key>,
}

/// Sites in a box, ready to give each site's cell.
#[derive(Clone, Debug)]
pub struct Cells {
    pub(super) sites: Vec<Vec3>,
    pub(super) low: Vec3,
    pub(super) high: Vec3,
    pub(super) grid: SiteGrid,
}

impl Cells {
    /// Puts the sites into buckets. `low` and `high` are opposite corners of the box \[m\].
    ///
    /// # Errors
    /// An empty box, no or too many sites, a site outside the box.
    pub fn new(sites: Vec<Vec3>, low: Vec3, high: Vec3) -> Result<Self, VoronoiError> {
        for axis in 0..3 {
            let (low, high) = (low[axis], high[axis]);
            if !(low.is_finite() && high.is_finite() && low < high) {
                return Err(VoronoiError::Box { axis, low, high });
            }
        }
        if sites.is_empty() || sites.len() > MAX_SITES {
            return Err(VoronoiError::Count { count: sites.len() });
        }
        let inside = |p: &Vec3| (0..3).all(|k| low[k] < p[k] && p[k] < high[k]);
        if let Some(site) = sites.iter().position(|p| !inside(p)) {
            return Err(VoronoiError::Outside { site });
        }
        let grid = SiteGrid::new(&sites, low, high);
        Ok(Self { sites, low, high, grid })
    }

    /// The sites \[m\].
    #[must_use]
    pub fn sites(&self) -> &[Vec3] {
        &self.sites
    }

    /// The lower corner of the box \[m\].
    #[must_use]
    pub fn low(&self) -> Vec3 {
        self.low
    }

    /// The upper corner of the box \[m\].
    #[must_use]
    pub fn high(&self) -> Vec3 {
        self.high
    }

    /// Where a corner is \[m\]: the same bits whoever asks.
    #[must_use]
    pub fn position(&self, key: &Key) -> Vec3 {
        let origin = self.sites[key[0] as usize];
        let mut planes = [ClipPlane::default(); 3];
        for (plane, &id) in planes.iter_mut().zip(&key[1..]) {
            *plane = self.plane(origin, id);
        }
        let mut place = meet([&planes[0], &planes[1], &planes[2]]).0 + origin;
        for k in 0..3 {
            // Rounding must not carry a corner out of the box, and one on a wall is exactly on it.
            place[k] = place[k].clamp(self.low[k], self.high[k]);
        }
        for &id in &key[1..] {
            if let Some((axis, at)) = self.wall(id) {
                place[axis] = at;
            }
        }
        place
    }

    /// The site nearest to `point`; of equals, the one with the smallest number.
    #[must_use]
    pub fn nearest(&self, point: Vec3) -> u32 {
        self.grid.nearest(&self.sites, point, |_| true).unwrap_or(0)
    }

    /// The nearest site among those that `wanted` accepts.
    #[must_use]
    pub fn nearest_of(&self, point: Vec3, wanted: impl Fn(u32) -> bool) -> Option<u32> {
        self.grid.nearest(&self.sites, point, wanted)
    }

    /// The axis and the coordinate of wall `id`, if it is one.
    pub(super) fn wall(&self, id: u32) -> Option<(usize, f64)> {
        let k = id.checked_sub(WALL)? as usize;
        let bound = if k.is_multiple_of(2) { self.low } else { self.high };
        Some((k / 2, bound[k / 2]))
    }

    /// The plane between the site at `origin` and generator `id`, in coordinates from `origin`.
    pub(super) fn plane(&self, origin: Vec3, id: u32) -> ClipPlane {
        if let Some((axis, at)) = self.wall(id) {
            let sign = if (id - WALL).is_multiple_of(2) { -1.0 } else { 1.0 };
            let mut normal = Vec3::zeros();
            normal[axis] = sign;
            return ClipPlane { id, normal, offset: sign * (at - origin[axis]), length: 1.0 };
        }
        let normal = self.sites[id as usize] - origin;
        let square = normal.norm_squared();
        ClipPlane { id, normal, offset: 0.5 * square, length: square.sqrt() }
    }
}
