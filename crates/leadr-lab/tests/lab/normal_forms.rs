//! Forms for the distribution of normals under a pixel.

use leadr_lab::hard_edges::{bricks, studs, tiles};
use leadr_lab::normal_forms_study::{Form, Normals, heavy_tails};
use leadr_maps::{HeightMap, load_height_map, procedural};
use leadr_testing::shared::shared_data;

const SIZE: u32 = 512;
const ALPHAS: [f64; 2] = [0.35, 0.1];
const FORMS: [Form; 8] = [
    Form::Gaussians(1),
    Form::Gaussians(2),
    Form::Gaussians(4),
    Form::Lobes(1),
    Form::Lobes(4),
    Form::Harmonics(8),
    Form::Harmonics(16),
    Form::Harmonics(24),
];

fn scan(name: &str, depth: f64) -> Option<Normals> {
    let folder = shared_data(&format!("displacement/{name}"))?;
    let map = load_height_map(folder.join(format!("{name}_1K-PNG_Displacement.png"))).expect("a height map");
    let step = map.width / SIZE;
    let texels = (0..SIZE * SIZE).map(|i| map.texels[((i / SIZE * map.width + i % SIZE) * step) as usize]).collect();
    Some(Normals::new(HeightMap { width: SIZE, height: SIZE, texels }, depth))
}

/// Prints the errors of all forms, and returns them.
fn errors(name: &str, normals: &Normals, alpha: f64) -> [f64; FORMS.len()] {
    let row = normals.errors(FORMS, alpha);
    println!("| {name} | {alpha} |{}", row.map(|e| format!(" {:.1} |", 100.0 * e)).concat());
    row
}

fn gaussian() -> Normals {
    Normals::new(procedural::gaussian(SIZE, SIZE, 3, 0.3, 0.006), 1.0)
}

/// Gaussians of classes follow relief with heavy tails and hard edges, and harmonics need many more floats.
#[test]
#[ignore = "takes half a minute"]
fn forms_of_normals() {
    let alpha = ALPHAS[1];
    // The classes of a Gaussian field are found on a sample of its facets.
    assert!(errors("Gaussian field, σ .3", &gaussian(), alpha)[0] < 0.06);
    let steep = [
        ("heavy tails, σ .3", heavy_tails(SIZE, 0.3, 0.7)),
        ("bricks", bricks(SIZE)),
        ("studs", studs(SIZE, 9.0, 4.0, 0.5, 6.0)),
    ];
    for (name, map) in steep {
        let [one, _, four, _, _, degree_8, ..] = errors(name, &Normals::new(map, 1.0), alpha);
        assert!(four < 0.3 * one && degree_8 > 0.25, "{name}: {one} {four} {degree_8}");
    }
}

/// The table of docs/measurements/textures.md.
#[test]
#[ignore = "by hand: minutes"]
fn table_of_forms() {
    let size = f64::from(SIZE);
    let made = [
        ("Gaussian field, σ .3", gaussian()),
        ("heavy tails, σ .3", Normals::new(heavy_tails(SIZE, 0.3, 0.7), 1.0)),
        ("bricks", Normals::new(bricks(SIZE), 1.0)),
        ("studs", Normals::new(studs(SIZE, 9.0, 4.0, 0.5, 6.0), 1.0)),
        ("roof tiles", Normals::new(tiles(SIZE), 1.0)),
        ("scratches", Normals::new(procedural::scratches(SIZE, SIZE, 1, 60), 2.0 / size)),
    ];
    let scans = [("metal walkway (scan)", "MetalWalkway006", 0.01), ("leather (scan)", "Leather027", 0.015)];
    let scans = scans.into_iter().filter_map(|(title, name, depth)| Some((title, scan(name, depth)?)));
    println!("{:?}", FORMS.map(|form| (form, form.floats())));
    for (name, normals) in made.into_iter().chain(scans) {
        for alpha in ALPHAS {
            assert!(errors(name, &normals, alpha).iter().all(|error| error.is_finite()), "{name}");
        }
    }
}
