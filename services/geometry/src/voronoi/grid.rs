//! Sites in buckets, and walks through the buckets in growing distance.

use crate::math::Vec3;

/// Buckets are halved until a site shares its bucket with at most this many others on average.
const CROWD: f64 = 6.0;
/// Buckets per site at most: more is memory that a walk then has to cross.
const BUCKETS_PER_SITE: usize = 32;

/// A dense grid of buckets over the box.
#[derive(Clone, Debug)]
pub(super) struct SiteGrid {
    low: Vec3,
    size: f64,
    dims: [usize; 3],
    /// Where each bucket starts in `order`; one more than there are buckets.
    starts: Vec<u32>,
    /// Site numbers, bucket by bucket, ascending within one.
    order: Vec<u32>,
}

impl SiteGrid {
    pub(super) fn new(sites: &[Vec3], low: Vec3, high: Vec3) -> Self {
        let extent = high - low;
        let longest = extent.max();
        let target = sites.len() as f64 * 0.5;
        let flat = extent.map(|x| x.max(1e-3 * longest));
        let mut size = libm::cbrt(flat.x * flat.y * flat.z / target.max(1.0));
        loop {
            let grid = Self::fill(sites, low, extent, size);
            let shared: f64 =
                grid.starts.windows(2).map(|w| f64::from(w[1] - w[0])).map(|c| c * c).sum();
            let next = grid.dims.iter().map(|&d| 2 * d).product::<usize>();
            if shared <= CROWD * sites.len() as f64 || next > BUCKETS_PER_SITE * sites.len() {
                return grid;
            }
            size *= 0.5;
        }
    }

    fn fill(sites: &[Vec3], low: Vec3, extent: Vec3, size: f64) -> Self {
        let dims = [0, 1, 2].map(|k| ((extent[k] / size).ceil() as usize).max(1));
        let mut grid = Self { low, size, dims, starts: Vec::new(), order: Vec::new() };
        let homes: Vec<usize> = sites.iter().map(|&p| grid.index(grid.home(p))).collect();
        let mut starts = vec![0u32; dims.iter().product::<usize>() + 1];
        for &home in &homes {
            starts[home + 1] += 1;
        }
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut next = starts.clone();
        grid.order = vec![0; sites.len()];
        for (site, &home) in homes.iter().enumerate() {
            grid.order[next[home] as usize] = site as u32;
            next[home] += 1;
        }
        grid.starts = starts;
        grid
    }

    /// The bucket of a point; the nearest one for points outside the box.
    fn home(&self, point: Vec3) -> [usize; 3] {
        [0, 1, 2].map(|k| {
            let cell = ((point[k] - self.low[k]) / self.size).max(0.0) as usize;
            cell.min(self.dims[k] - 1)
        })
    }

    fn index(&self, bucket: [usize; 3]) -> usize {
        (bucket[2] * self.dims[1] + bucket[1]) * self.dims[0] + bucket[0]
    }

    /// Calls `visit(sites, squared distance from point to bucket)` for the buckets of ring `radius`
    /// around the point's own. False once the ring lies wholly outside the grid.
    pub(super) fn ring(
        &self,
        point: Vec3,
        radius: usize,
        mut visit: impl FnMut(&[u32], f64),
    ) -> bool {
        let home = self.home(point);
        let low = home.map(|h| h.saturating_sub(radius));
        let high = [0, 1, 2].map(|k| (home[k] + radius).min(self.dims[k] - 1));
        let gap = |k: usize, cell: usize| {
            let start = self.low[k] + cell as f64 * self.size;
            (start - point[k]).max(point[k] - start - self.size).max(0.0)
        };
        let mut met = false;
        for z in low[2]..=high[2] {
            let far_z = z.abs_diff(home[2]) == radius;
            let dz = gap(2, z);
            for y in low[1]..=high[1] {
                let far = far_z || y.abs_diff(home[1]) == radius;
                let dy = gap(1, y);
                let row = self.index([0, y, z]);
                let mut look = |x: usize| {
                    met = true;
                    let (start, end) = (self.starts[row + x], self.starts[row + x + 1]);
                    if start < end {
                        let dx = gap(0, x);
                        let sites = &self.order[start as usize..end as usize];
                        visit(sites, dx * dx + dy * dy + dz * dz);
                    }
                };
                if far {
                    (low[0]..=high[0]).for_each(look);
                } else {
                    if home[0] >= radius {
                        look(home[0] - radius);
                    }
                    if home[0] + radius < self.dims[0] {
                        look(home[0] + radius);
                    }
                }
            }
        }
        met
    }

    /// No site in ring `radius` or beyond is nearer to the point than this \[m\].
    pub(super) fn reach(&self, point: Vec3, radius: usize) -> f64 {
        let home = self.home(point);
        let within = (0..3).map(|k| {
            let start = self.low[k] + home[k] as f64 * self.size;
            (point[k] - start).min(start + self.size - point[k])
        });
        let inner = within.fold(f64::INFINITY, f64::min);
        // One part in 1e9 less, for the rounding of the buckets' bounds.
        (inner + (radius as f64 - 1.0) * self.size) - 1e-9 * self.size
    }

    pub(super) fn nearest(
        &self,
        sites: &[Vec3],
        point: Vec3,
        wanted: impl Fn(u32) -> bool,
    ) -> Option<u32> {
        let mut best: Option<(f64, u32)> = None;
        for radius in 0.. {
            if let Some((square, _)) = best {
                let reach = self.reach(point, radius);
                if reach > 0.0 && reach * reach > square {
                    break;
                }
            }
            let met = self.ring(point, radius, |bucket, gap| {
                if best.is_some_and(|(square, _)| gap > square * (1.0 + 1e-9)) {
                    return;
                }
                for &site in bucket {
                    let square = (sites[site as usize] - point).norm_squared();
                    let closer = best.is_none_or(|b| (square, site) < b);
                    if closer && wanted(site) {
                        best = Some((square, site));
                    }
                }
            });
            if !met {
                break;
            }
        }
        best.map(|(_, site)| site)
    }
}
