//! Triangles to pixels: a depth buffer, a buffer of who is seen, and a buffer of normals.

use cullet_geometry::Vec3;

/// Nobody is seen at a pixel.
pub(super) const NOBODY: u32 = u32::MAX;

/// A corner on the screen.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScreenCorner {
    /// Pixels from the left.
    pub(super) x: f64,
    /// Pixels from the top.
    pub(super) y: f64,
    /// Grows towards the viewer and is linear on the screen (1/distance, or −distance).
    pub(super) near: f64,
}

/// What is seen at each pixel.
pub(super) struct Buffers {
    pub(super) width: usize,
    pub(super) height: usize,
    /// [`ScreenCorner::near`] of the nearest surface; −∞ where there is none.
    pub(super) near: Vec<f32>,
    /// Who it belongs to; empty if only depth is wanted.
    pub(super) who: Vec<u32>,
    /// Its normal in the world.
    pub(super) normal: Vec<[f32; 3]>,
    /// Of a surface that shows a quantity: how much of it there is \[1\]. Empty if there are none.
    pub(super) tint: Vec<f32>,
}

/// An edge as a half plane: a·x + b·y + c ≥ 0 inside.
struct Edge {
    a: f64,
    b: f64,
    c: f64,
}

impl Edge {
    fn between(p: ScreenCorner, q: ScreenCorner) -> Self {
        Self { a: p.y - q.y, b: q.x - p.x, c: p.x * q.y - p.y * q.x }
    }

    fn at(&self, x: f64, y: f64) -> f64 {
        self.a * x + self.b * y + self.c
    }
}

/// A triangle on the screen.
struct ScreenTriangle {
    edges: [Edge; 3],
    /// Turns edge functions into the shares of the corners \[1\].
    scale: f64,
    /// [`ScreenCorner::near`] as a function of the place.
    near: Edge,
    who: u32,
    tints: Option<[f32; 3]>,
}

impl Buffers {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let n = width * height;
        Self { who: vec![NOBODY; n], normal: vec![[0.0; 3]; n], ..Self::depth(width, height) }
    }

    /// With room for quantities.
    pub(super) fn tinted(width: usize, height: usize) -> Self {
        Self { tint: vec![0.0; width * height], ..Self::new(width, height) }
    }

    /// Depth alone, for shadows.
    pub(super) fn depth(width: usize, height: usize) -> Self {
        let near = vec![f32::NEG_INFINITY; width * height];
        let (who, normal, tint) = (Vec::new(), Vec::new(), Vec::new());
        Self { width, height, near, who, normal, tint }
    }

    /// Draws a triangle whose corners run counter-clockwise on a screen with y up, that is
    /// clockwise here. Others show their back and are left out, as is one that covers no pixel.
    /// `normals` is asked only where something is drawn.
    pub(super) fn triangle(
        &mut self,
        corners: [ScreenCorner; 3],
        who: u32,
        normals: impl FnOnce() -> [Vec3; 3],
    ) {
        self.tinted_triangle(corners, who, None, normals);
    }

    /// The same, with a quantity at each corner.
    pub(super) fn tinted_triangle(
        &mut self,
        corners: [ScreenCorner; 3],
        who: u32,
        tints: Option<[f32; 3]>,
        normals: impl FnOnce() -> [Vec3; 3],
    ) {
        let [p, q, r] = corners;
        let area = (q.x - p.x) * (r.y - p.y) - (r.x - p.x) * (q.y - p.y);
        let (low, high) = span(p.y, q.y, r.y);
        let (left, right) = span(p.x, q.x, r.x);
        let rows = pixel_range(low, high, self.height);
        let columns = pixel_range(left, right, self.width);
        // `>=` also turns away an area that is not a number.
        let front = area < 0.0;
        if !front || rows.is_empty() || columns.is_empty() {
            return;
        }
        // Turned over so that all edge functions are positive inside.
        let edges = [Edge::between(r, q), Edge::between(p, r), Edge::between(q, p)];
        let scale = 1.0 / -area;
        let weigh = |part: fn(&Edge) -> f64| {
            scale * edges.iter().zip(&corners).map(|(e, c)| part(e) * c.near).sum::<f64>()
        };
        let near = Edge { a: weigh(|e| e.a), b: weigh(|e| e.b), c: weigh(|e| e.c) };
        let facet = ScreenTriangle { edges, scale, near, who, tints };
        let wanted = (!self.who.is_empty()).then(normals);
        for y in rows {
            self.row(y, &columns, &facet, wanted.as_ref());
        }
    }

    fn row(
        &mut self,
        y: usize,
        columns: &std::ops::Range<usize>,
        facet: &ScreenTriangle,
        normals: Option<&[Vec3; 3]>,
    ) {
        let yc = y as f64 + 0.5;
        let (mut from, mut to) = (columns.start as f64 + 0.5, columns.end as f64 - 0.5);
        for edge in &facet.edges {
            let rest = edge.b * yc + edge.c;
            if edge.a > 0.0 {
                from = from.max(-rest / edge.a);
            } else if edge.a < 0.0 {
                to = to.min(-rest / edge.a);
            } else if rest < 0.0 {
                return;
            }
        }
        let first = (from - 0.5).ceil().max(0.0) as usize;
        let last = (to - 0.5).floor();
        if last < first as f64 {
            return;
        }
        let end = (last as usize + 1).min(self.width);
        self.span(y, first..end, facet, normals);
    }

    /// Draws what of a row lies inside.
    fn span(
        &mut self,
        y: usize,
        columns: std::ops::Range<usize>,
        facet: &ScreenTriangle,
        normals: Option<&[Vec3; 3]>,
    ) {
        let yc = y as f64 + 0.5;
        let along = facet.near.b * yc + facet.near.c;
        let near = |x: i32| (facet.near.a * (f64::from(x) + 0.5) + along) as f32;
        let from = columns.start as i32;
        let line = y * self.width + columns.start..y * self.width + columns.end;
        let depth = &mut self.near[line.clone()];
        let Some([a, b, c]) = normals else {
            for (x, old) in (from..).zip(depth) {
                let near = near(x);
                *old = if near > *old { near } else { *old };
            }
            return;
        };
        let bytes = |n: Vec3| [n.x as f32, n.y as f32, n.z as f32];
        let flat = (a == b && b == c).then(|| bytes(*a));
        let shares = |x: i32| {
            let xc = f64::from(x) + 0.5;
            facet.edges.each_ref().map(|e| e.at(xc, yc) * facet.scale)
        };
        let tint = self.tint.get_mut(line.clone()).unwrap_or_default();
        let seen = self.who[line.clone()].iter_mut().zip(&mut self.normal[line]);
        for (k, ((x, old), (who, normal))) in (from..).zip(depth).zip(seen).enumerate() {
            let near = near(x);
            if near > *old {
                (*old, *who) = (near, facet.who);
                *normal = flat.unwrap_or_else(|| {
                    let share = shares(x);
                    bytes(a * share[0] + b * share[1] + c * share[2])
                });
                if let (Some(tints), Some(tint)) = (facet.tints, tint.get_mut(k)) {
                    let parts =
                        tints.iter().zip(shares(x)).map(|(tint, share)| tint * share as f32);
                    *tint = parts.sum();
                }
            }
        }
    }
}

fn span(a: f64, b: f64, c: f64) -> (f64, f64) {
    (a.min(b).min(c), a.max(b).max(c))
}

/// The pixels whose centres lie in `[low, high]`.
fn pixel_range(low: f64, high: f64, size: usize) -> std::ops::Range<usize> {
    let from = (low - 0.5).ceil().max(0.0);
    let to = ((high - 0.5).floor() + 1.0).min(size as f64);
    if from < to { from as usize..to as usize } else { 0..0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f64, y: f64, near: f64) -> ScreenCorner {
        ScreenCorner { x, y, near }
    }

    fn draw(buffers: &mut Buffers, corners: [ScreenCorner; 3], who: u32) {
        buffers.triangle(corners, who, || [Vec3::z(); 3]);
    }

    #[test]
    fn two_triangles_of_a_square_cover_each_pixel_once() {
        let (a, b) = (corner(2.0, 2.0, 1.0), corner(12.0, 2.0, 1.0));
        let (c, d) = (corner(12.0, 12.0, 1.0), corner(2.0, 12.0, 1.0));
        let mut buffers = Buffers::new(16, 16);
        draw(&mut buffers, [a, c, b], 1);
        draw(&mut buffers, [a, d, c], 2);
        let seen = |who| buffers.who.iter().filter(|&&w| w == who).count();
        assert_eq!(seen(1) + seen(2), 100);
        assert_eq!(seen(NOBODY), 156);
    }

    #[test]
    fn the_nearer_one_is_seen_and_backs_are_not() {
        let at = |near| [corner(0.0, 0.0, near), corner(0.0, 8.0, near), corner(8.0, 0.0, near)];
        let mut buffers = Buffers::new(8, 8);
        draw(&mut buffers, at(0.5), 1);
        draw(&mut buffers, at(0.7), 2);
        draw(&mut buffers, at(0.6), 3);
        assert_eq!(buffers.who[9], 2);
        let [p, q, r] = at(0.9);
        draw(&mut buffers, [p, r, q], 4);
        assert_eq!(buffers.who[9], 2);
    }

    #[test]
    fn depth_is_linear_on_the_screen_also_when_the_triangle_leaves_it() {
        let mut buffers = Buffers::new(10, 10);
        let corners = [corner(-1e4, -1e4, -1e4), corner(-1e4, 3e4, -1e4), corner(3e4, -1e4, 3e4)];
        draw(&mut buffers, corners, 1);
        for (index, near) in buffers.near.iter().enumerate() {
            let expected = (index % 10) as f32 + 0.5;
            assert!((near - expected).abs() < 1e-3, "{index}: {near}");
        }
    }

    #[test]
    fn what_is_not_a_number_draws_nothing() {
        let mut buffers = Buffers::new(4, 4);
        draw(
            &mut buffers,
            [corner(f64::NAN, 0.0, 1.0), corner(0.0, 4.0, 1.0), corner(4.0, 0.0, 1.0)],
            1,
        );
        assert!(buffers.who.iter().all(|&w| w == NOBODY));
    }
}
