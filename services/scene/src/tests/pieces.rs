//! How many pieces, where, and what stays whole.

use super::{SMALL, errors_of, from_text};
use cullet_geometry::Vec3;
use cullet_model::{ArtDirection, BodyRegion};

/// A cone's centroid is a quarter up from its base: places are the shape's own.
#[test]
fn pieces_are_in_the_bodys_own_frame() {
    let cone = "[[body]]\nname = \"cone\"\nmaterial = \"granite\"\nposition = [0, 3, 1]\n\
                shape = { kind = \"cone\", radius = 0.1, height = 0.4 }\n\
                rotation = { axis = [1, 0, 0], degrees = 90 }\n[body.pieces]\ncount = 12\n\
                guides = [[0, 0, 0], [\"2 cm\", 0, \"-1 dm\"]]\n\
                whole = [{ centre = [0, 0, 0.1], radius = \"3 cm\" }]\n";
    let scene = from_text(&format!("{SMALL}{cone}"), &[]).unwrap_or_else(|why| panic!("{why}"));
    let up = Vec3::new(0.0, 0.0, 0.1);
    let direction = ArtDirection {
        pieces: Some(12),
        guides: vec![up, up + Vec3::new(0.02, 0.0, -0.1)],
        whole: vec![BodyRegion::Ball { centre: up + Vec3::new(0.0, 0.0, 0.1), radius: 0.03 }],
    };
    let found = scene.bodies[2].direction.as_deref().expect("it is directed");
    assert_eq!(found.pieces, direction.pieces);
    for (a, b) in found.guides.iter().zip(&direction.guides) {
        assert!((a - b).norm() < 1e-9, "{a} is not {b}");
    }
    assert!((found.whole[0].middle() - direction.whole[0].middle()).norm() < 1e-9);
    assert!(scene.is_directed() && scene.bodies[0].direction.is_none());
}

#[test]
fn what_cannot_be_asked_for_is_said_with_its_place() {
    let all = ["body.cube.pieces.guides=[[0,0,0],[0.05,0,0],[-0.05,0,0]]"];
    for (more, words) in [
        ("body.cube.pieces={}", ["body.cube.pieces", "`count`, `guides` or `whole`"]),
        ("body.cube.pieces.count=1", ["body.cube.pieces.count", "at least 2"]),
        ("body.cube.pieces.count=401", ["body.cube.pieces.count", "`fracture.max_fragments`, 400"]),
        ("body.cube.pieces.count=2", ["body.cube.pieces.count", "number of `guides`, 3; it is 2"]),
        ("body.cube.breakable=false", ["body.cube.pieces", "the body does not break"]),
        ("body.cube.pieces.guides=[[0,0,0.2]]", ["body.cube.pieces.guides[0]", "outside the body"]),
        (
            "body.cube.pieces.guides=[[0,0,0],[0.05,0,0],[0,0,1e-6]]",
            ["body.cube.pieces.guides[2]", "`guides[0]` is nearer"],
        ),
        (
            "body.cube.pieces.whole=[{low=[-1,-1,-1],high=[1,1,1]}]",
            ["body.cube.pieces.whole[0]", "at most one of the `guides`; it holds 3"],
        ),
        (
            "body.cube.pieces.whole=[{centre=[1,0,0],radius=0.1}]",
            ["body.cube.pieces.whole[0]", "holds no part of the body"],
        ),
        (
            "body.cube.pieces.whole=[{centre=[0,0,0]}]",
            ["body.cube.pieces.whole[0]", "takes `low` and `high`, or `centre` and `radius`"],
        ),
    ] {
        let said = errors_of(SMALL, &[all[0], more]);
        for word in words {
            assert!(said.contains(word), "no \"{word}\" in:\n{said}\nof {more}");
        }
    }
}
