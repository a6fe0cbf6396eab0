//! The files of `tests/corpus/meshes` through the reader and the door: what is no clean solid is
//! refused by name where repair is not wanted; where it is, it is repaired with a report, or
//! refused by name. A comment in each file says what it is.

use crate::kit::is_solid;
use cullet_assets::MeshFileError;
use cullet_geometry::door::{DoorError, Repair, admit};
use cullet_tests::{files, root};

/// What comes of a file.
enum Fate {
    /// The reader refuses it: the start of its error's name and words of the message.
    Unread(&'static str, &'static str),
    /// It is clean.
    Clean(f64),
    /// Its defect's name; words of the report; the volume \[m³\] and how near to it \[1\].
    Mended(&'static str, &'static str, f64, f64),
    /// Its defect's name, and why repair gives up.
    Refused(&'static str, &'static str),
}

use Fate::{Clean, Mended, Refused, Unread};

const FATES: &[(&str, Fate)] = &[
    ("almost.obj", Mended("SelfIntersecting", "crossing shells joined", 2.0, 1e-6)),
    ("atom.obj", Refused("Size", "across; 1e-7 to 1e6 m are taken")),
    ("bow.obj", Refused("Inverted", "encloses no volume")),
    ("clean.obj", Clean(1.0)),
    ("corner.obj", Clean(2.0)),
    (
        "crossing.obj",
        Mended("SelfIntersecting", "crossing shells joined", 2.0 - 0.5 * 0.75 * 0.875, 1e-9),
    ),
    ("duplicate.ply", Mended("Duplicate", "3 repeated triangles dropped", 1.0, 1e-9)),
    ("edge.obj", Mended("NonManifold", "1 crowded edges taken apart", 2.0, 1e-9)),
    ("empty.obj", Unread("Empty", "no triangles")),
    ("fan.obj", Mended("OpenEdges", "1 holes of 8 open edges closed", 0.666_530_42, 1e-7)),
    ("far.obj", Clean(1.0)),
    ("flat.ply", Mended("Degenerate", "dropped", 1.0, 1e-9)),
    ("hollow.obj", Clean(0.875)),
    ("infinite.ply", Unread("Malformed", "line 18: ")),
    ("inverted.obj", Mended("Inverted", "12 triangles turned over", 1.0, 1e-9)),
    ("junction.obj", Mended("OpenEdges", "1 triangles divided at T-junctions", 1.0, 1e-9)),
    ("kissing.obj", Mended("Duplicate", "repeated triangles dropped", 2.0, 1e-9)),
    ("leaf.obj", Refused("Duplicate", "encloses no volume")),
    ("loop.obj", Mended("SelfIntersecting", "crossing shells joined", 5.0 / 3.0, 1e-6)),
    ("micron.obj", Clean(1e-18)),
    ("missing.obj", Unread("IndexOutOfRange", "face 12 names corner 12, but there are 8")),
    ("mixed.ply", Mended("NotOriented", "4 triangles turned over", 1.0, 1e-9)),
    ("moebius.ply", Refused("OpenEdges", "remesh")),
    ("mountain.obj", Clean(1e12)),
    ("nan.obj", Unread("BadCoordinate", "corner 1 has the coordinate NaN")),
    ("needle.obj", Refused("Inverted", "encloses no volume")),
    ("nested.obj", Mended("Inverted", "1 flat or swallowed shells dropped", 1.0, 1e-9)),
    ("one.obj", Refused("OpenEdges", "encloses no volume")),
    ("open.obj", Mended("OpenEdges", "1 holes of 4 open edges closed", 1.0, 1e-9)),
    ("planet.obj", Unread("BadCoordinate", "within ±1e7")),
    ("sheet.ply", Refused("OpenEdges", "encloses no volume")),
    ("twins.obj", Mended("Duplicate", "12 repeated triangles dropped", 1.0, 1e-9)),
];

/// The name of an error's variant.
fn kind(error: &impl std::fmt::Debug) -> String {
    let text = format!("{error:?}");
    text.split([' ', '(', '{']).next().unwrap_or_default().to_owned()
}

fn door(name: &str, mesh: &cullet_geometry::TriMesh, fate: &Fate) {
    let strict = admit(mesh, Repair::Refuse);
    let mended = admit(mesh, Repair::Auto);
    let near = |volume: f64, wanted: f64, share: f64| (volume / wanted - 1.0).abs() <= share;
    if let Ok((solid, report)) = &mended {
        is_solid(solid);
        assert!((report.volume - solid.signed_volume()).abs() <= 1e-12 * report.volume, "{name}");
        let again = admit(solid, Repair::Refuse).map(|_| ());
        assert_eq!(again, Ok(()), "{name}: what was mended is clean");
    }
    match fate {
        Unread(..) => panic!("{name} was read"),
        Clean(volume) => {
            assert_eq!(strict.map(|_| ()), Ok(()), "{name}");
            let (_, report) = mended.expect(name);
            assert!(report.is_clean() && near(report.volume, *volume, 1e-6), "{name}: {report}");
        }
        Mended(defect, words, volume, share) => {
            let told = strict.map(|_| ()).expect_err(name);
            assert_eq!(kind(&told), *defect, "{name}: {told}");
            let (_, report) = mended.expect(name);
            assert!(report.to_string().contains(words), "{name}: {report}");
            assert!(near(report.volume, *volume, *share), "{name}: {report}");
        }
        Refused(defect, words) => {
            let told = strict.map(|_| ()).expect_err(name);
            assert_eq!(kind(&told), *defect, "{name}: {told}");
            let told: DoorError = mended.map(|_| ()).expect_err(name);
            assert!(told.to_string().contains(words), "{name}: {told}");
        }
    }
}

#[test]
fn bad_meshes_are_mended_or_refused_by_name() {
    let folder = root().join("tests/corpus/meshes");
    let found: Vec<String> = files(&folder, &[""])
        .iter()
        .map(|path| path.file_name().expect("a name").to_string_lossy().into_owned())
        .collect();
    let listed: Vec<&str> = FATES.iter().map(|(name, _)| *name).collect();
    assert_eq!(found, listed, "every file has its fate");
    for (name, fate) in FATES {
        let bytes = std::fs::read(folder.join(name)).expect("a mesh");
        match (cullet_assets::read(name, &bytes), fate) {
            (Ok(mesh), fate) => door(name, &mesh, fate),
            (Err(error), Unread(defect, words)) => {
                let error: MeshFileError = error;
                assert_eq!(kind(&error), *defect, "{name}: {error}");
                assert!(error.to_string().contains(words), "{name}: {error}");
            }
            (Err(error), _) => panic!("{name}: {error}"),
        }
    }
}
