//! The period estimate: against the same estimator on closed forms, for what it is worth, and what it must refuse.
#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

use std::path::Path;

use diffraction_shaders::height::{HeightField, synthetic::synthesise};
use diffraction_shaders::optics::window_sigma_um;
use diffraction_shaders::plan::{Grating, Optics, Plan, Variant, Wavelengths};
use diffraction_shaders::resolve::resolve;
use diffraction_shaders::runner::{Runner, Subject, TwinRunner};
use diffraction_shaders::testbench::{self, Lobe, Measurement, Profile, Protocol};

fn variant(keys: &str) -> Variant {
    let text = format!(
        "schema = 1\n[[surface]]\nname = \"a\"\ngrating = {{ kind = \"flat\", period_um = 2.5, pixels = 100 }}\n[variants]\nterms = \"auto\"\nterm_error = 1e-6\n{keys}\n"
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap_or_else(|e| panic!("{keys}: {e}"));
    plan.variants[0].clone()
}

fn protocol(expected_um: f64) -> Protocol {
    let wavelengths = Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm: 5.0 };
    Protocol { theta_i_deg: 75.0, phi_i_deg: 0.0, wavelengths, expected_um, whole: false }
}

fn height(grating: &Grating) -> HeightField {
    synthesise(grating, "grating").unwrap().field
}

fn by_twin(height: &HeightField, variant: &Variant, protocol: Protocol) -> Measurement {
    let subject = Subject { height, rotate_deg: 0.0, variant };
    let twin = TwinRunner::new(subject, true).unwrap();
    let extent_um = testbench::extent_um(subject, 780.0).unwrap();
    testbench::measure(&protocol, extent_um, testbench::runner(&twin, protocol)).unwrap()
}

fn exactly(height: &HeightField, protocol: Protocol) -> Measurement {
    let variant = Variant::texts(&Optics::standard());
    let subject = Subject { height, rotate_deg: 0.0, variant: &variant };
    testbench::measure(&protocol, 65.0, testbench::exact(subject, protocol).unwrap()).unwrap()
}

fn closed(grating: &Grating, protocol: Protocol, lobe: Lobe, extent_um: f64) -> Measurement {
    let profile = Profile::new(grating).unwrap();
    let respond = testbench::profile(&profile, protocol, 0.0, |_| lobe);
    testbench::measure(&protocol, extent_um, respond).unwrap()
}

fn window() -> Lobe {
    Lobe::Window { sigma_um: window_sigma_um(&Optics::standard(), 550.0) }
}

#[test]
fn explore() {
    for (name, grating, d) in [
        ("blazed .25", Grating::Blazed { period_um: 2.5, height_um: 0.25, pixels: 100 }, 2.5),
        ("blazed .30", Grating::Blazed { period_um: 2.5, height_um: 0.30, pixels: 100 }, 2.5),
        ("blazed .25 n28", Grating::Blazed { period_um: 2.5, height_um: 0.25, pixels: 28 }, 2.5),
        ("blazed .25 n400", Grating::Blazed { period_um: 2.5, height_um: 0.25, pixels: 400 }, 2.5),
        ("cd sin", Grating::Sinusoidal { period_um: 1.6, height_um: 0.12, pixels: 100 }, 1.6),
        ("lamellar", Grating::Lamellar { period_um: 1.0, height_um: 0.15, pixels: 100, duty: 0.4 }, 1.0),
        ("triangle", Grating::Triangle { period_um: 2.0, height_um: 0.3, pixels: 100, apex: 0.3 }, 2.0),
    ] {
        let h = height(&grating);
        let p = protocol(d);
        let show = |what: &str, m: &Measurement| {
            println!(
                "{name:16} {what:16} {:.4} sd {:.4} points {} ev {} flat {} weight {:.2e} evals {}",
                m.period_nm, m.sd_nm, m.points, m.evanescent, m.flat, m.weight, m.evaluations
            );
        };
        show("closed", &closed(&grating, p, window(), 65.0));
        show("closed grid", &closed(&grating, p, window(), 1e9));
        show("exact", &exactly(&h, p));
        for mode in ["full", "adaptive"] {
            show(mode, &by_twin(&h, &variant(&format!("mode = \"{mode}\"")), p));
        }
        for keys in ["", "window_radius = 2", "window_radius = 8", "window_radius = 50", "window_radius = \"auto\"", "window_radius = 50\nperiods = [104, 650]"] {
            let pq = variant(&format!("mode = \"pq\"\n{keys}"));
            let r = resolve(&pq, &h).unwrap();
            let lobe = Lobe::Replicas {
                periods: f64::from(r.periods[0]),
                length_um: f64::from(r.periods[1]) * r.patch_um[1],
            };
            let extent = f64::from(r.periods[0]) * d;
            show(&format!("pq closed {:?}", r.periods), &closed(&grating, p, lobe, extent));
            show(&format!("pq taps {:?}", r.taps), &by_twin(&h, &pq, p));
        }
    }
}
