//! Components are visible to inspectors and scene files.

use core::any::TypeId;

use crate::common::*;
use bevy::prelude::*;
use bevy::reflect::{GetPath, TypeRegistration};
use bevy_cloth::physics::{
    BendingModel, Fabric, Integrator, Precision, PreconditionerKind, SolverKind, SolverSettings,
};
use bevy_cloth::plugin::*;

fn registration<T: 'static>(app: &App) -> TypeRegistration {
    let registry = app.world().resource::<AppTypeRegistry>().read();
    registry.get(TypeId::of::<T>()).unwrap_or_else(|| panic!("{}", core::any::type_name::<T>())).clone()
}

#[test]
fn everything_is_registered() {
    let app = app();
    let components = [
        registration::<ClothMesh>(&app),
        registration::<ClothMaterial>(&app),
        registration::<ClothPins>(&app),
        registration::<ClothPinTargets>(&app),
        registration::<ClothSolver>(&app),
        registration::<ClothQuality>(&app),
        registration::<ClothImportance>(&app),
        registration::<ClothDisabled>(&app),
        registration::<ClothError>(&app),
        registration::<ClothCollider>(&app),
        registration::<ClothColliderError>(&app),
        registration::<ClothMeshCollider>(&app),
        registration::<ClothContact>(&app),
        registration::<ClothContacts>(&app),
        registration::<ClothLayers>(&app),
        registration::<ClothCollidesWith>(&app),
        registration::<ClothId>(&app),
        registration::<ClothSnapshot>(&app),
        registration::<ClothSource>(&app),
    ];
    for component in components {
        assert!(component.data::<ReflectComponent>().is_some(), "{component:?}");
    }
    for resource in [
        registration::<ClothGravity>(&app),
        registration::<ClothDefaultQuality>(&app),
        registration::<ClothBudget>(&app),
        registration::<ClothBudgetReport>(&app),
    ] {
        assert!(resource.data::<ReflectResource>().is_some(), "{resource:?}");
    }
    assert!(registration::<ClothCollider>(&app).data::<ReflectDefault>().is_some());
    assert!(registration::<ClothShape>(&app).data::<ReflectDefault>().is_some());
    registration::<Fabric>(&app);
    registration::<PinRule>(&app);
}

/// Without it an inspector can neither add a rule nor switch the solver.
#[test]
fn what_is_nested_has_a_default() {
    let app = app();
    let nested = [
        registration::<Fabric>(&app),
        registration::<BendingModel>(&app),
        registration::<SolverSettings>(&app),
        registration::<SolverKind>(&app),
        registration::<PreconditionerKind>(&app),
        registration::<Precision>(&app),
        registration::<Integrator>(&app),
        registration::<PinRule>(&app),
        registration::<PinChannel>(&app),
        registration::<ClothBudget>(&app),
        registration::<ClothMeshShape>(&app),
    ];
    for kind in nested {
        assert!(kind.data::<ReflectDefault>().is_some(), "{kind:?}");
    }
    registration::<ClothTouch>(&app);
    registration::<ClothReset>(&app);
}

#[cfg(feature = "serialize")]
#[test]
fn what_a_user_writes_is_serialisable() {
    use bevy::reflect::{ReflectDeserialize, ReflectSerialize};
    let app = app();
    let written = [
        registration::<ClothMesh>(&app),
        registration::<ClothMaterial>(&app),
        registration::<ClothPins>(&app),
        registration::<ClothPinTargets>(&app),
        registration::<ClothQuality>(&app),
        registration::<ClothImportance>(&app),
        registration::<ClothDefaultQuality>(&app),
        registration::<ClothSolver>(&app),
        registration::<ClothDisabled>(&app),
        registration::<ClothGravity>(&app),
        registration::<ClothCollider>(&app),
        registration::<ClothId>(&app),
        registration::<ClothSnapshot>(&app),
    ];
    for component in written {
        let both = component.data::<ReflectSerialize>().is_some() && component.data::<ReflectDeserialize>().is_some();
        assert!(both, "{component:?}");
    }
}

#[test]
fn an_inspector_can_edit_a_running_cloth() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ());
    let reflected = registration::<ClothMaterial>(&app).data::<ReflectComponent>().unwrap().clone();
    let mut material = reflected.reflect_mut(app.world_mut().entity_mut(cloth)).unwrap();
    *material.path_mut::<f32>(".0.density").unwrap() = 0.5;
    run(&mut app, 1);
    let mass: f64 = state(&app, cloth).cloth().masses().iter().sum();
    assert!((mass - 0.5).abs() < 1e-6, "{mass}");
}

#[test]
fn rules_survive_reflection_and_predicates_are_left_out() {
    let rules = ClothPins::indices([1, 2]).or(ClothPins::in_box(Vec3::ZERO, Vec3::ONE));
    let reflected = rules.clone().or(top_edge()).to_dynamic();
    let back = ClothPins::from_reflect(&*reflected).unwrap();
    assert_eq!(back.rules, rules.rules);
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), back);
    assert_eq!(state(&app, cloth).pinned_vertices(), [0, 1, 2, 3, 4]);
}
