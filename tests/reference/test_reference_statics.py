from types import ModuleType

import numpy as np
import pytest

from gm_ompl.arrays import Array
from gm_ompl.reference.statics import (
    friction_cone,
    scaling_root,
    sliding_edge,
    statics,
    wrench_matrix,
)  # fmt: skip

X, Y, Z = np.eye(3)


def random_unit(rng: np.random.Generator) -> Array:
    v = rng.normal(size=3)
    return np.asarray(v / np.linalg.norm(v))


@pytest.mark.parametrize("edges", [3, 4, 6, 12])
def test_cone_edges_lie_on_the_coulomb_cone(edges: int) -> None:
    """Every edge is a unit vector whose tangential part is mu times its normal part."""
    rng = np.random.default_rng(edges)
    for _ in range(50):
        n, mu = random_unit(rng), rng.uniform(0, 2)
        cone = friction_cone(n, mu, edges, X, Y)
        assert cone.shape == (3, edges)
        np.testing.assert_allclose(np.linalg.norm(cone, axis=0), 1.0)
        normal = n @ cone
        tangential = np.linalg.norm(cone - np.outer(n, normal), axis=0)
        np.testing.assert_allclose(tangential, mu * normal, atol=1e-14)


def test_cone_edges_start_at_the_reference_axis() -> None:
    """Along z the first edge leans to +x and the next turn towards n x t1 = +y; along x, to y."""
    up = friction_cone(Z, 1.0, 4, X, Y) * np.sqrt(2)
    np.testing.assert_allclose(up.T, [[1, 0, 1], [0, 1, 1], [-1, 0, 1], [0, -1, 1]], atol=1e-12)
    aside = friction_cone(X, 1.0, 4, X, Y) * np.sqrt(2)
    np.testing.assert_allclose(aside.T, [[1, 1, 0], [1, 0, 1], [1, -1, 0], [1, 0, -1]], atol=1e-12)


def test_sliding_friction_opposes_the_slip() -> None:
    """The one edge of a contact sliding to +x pulls to -x with mu times the normal force."""
    edge = sliding_edge(Z, 0.5, X)
    np.testing.assert_allclose(edge / edge[2], [-0.5, 0.0, 1.0])
    assert np.linalg.norm(edge) == pytest.approx(1.0)


def test_wrench_matrix_is_force_and_cross_product() -> None:
    """W f stacks the sum of forces over the sum of p x f."""
    rng = np.random.default_rng(0)
    points, forces = rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
    wrench = wrench_matrix(points) @ forces.ravel()
    np.testing.assert_allclose(wrench[:3], forces.sum(axis=0))
    np.testing.assert_allclose(wrench[3:], np.cross(points, forces).sum(axis=0))


def test_norm_7_does_not_depend_on_the_axes() -> None:
    """|R^(1/2) Q| equals sqrt(Q^T R Q) of Eq. (7) and is the same in turned axes."""
    rng = np.random.default_rng(1)
    root = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    J = root @ np.diag([2.0, 3.0, 4.0]) @ root.T
    for _ in range(20):
        f, m = rng.normal(size=3), rng.normal(size=3)
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        here = np.linalg.norm(scaling_root(1.5, J) @ np.concatenate([f, m]))
        there = np.linalg.norm(
            scaling_root(1.5, turn @ J @ turn.T) @ np.concatenate([turn @ f, turn @ m])
        )
        assert here == pytest.approx(there)
        assert here**2 == pytest.approx(f @ f + 1.5 * m @ np.linalg.inv(J) @ m)


def test_root_is_the_upper_factor() -> None:
    """R^(1/2) is upper triangular with a positive diagonal, which makes it unique."""
    J = np.array([[3.0, 0.4, 0.1], [0.4, 2.0, -0.3], [0.1, -0.3, 2.5]])
    U = scaling_root(2.0, J)
    np.testing.assert_allclose(U, np.triu(U))
    assert (np.diag(U) > 0).all()
    np.testing.assert_allclose((U.T @ U)[3:, 3:], 2.0 * np.linalg.inv(J))


def test_gravity_is_one_weight_down_whatever_the_pose(instances: ModuleType) -> None:
    """With gravity on, Q_known is a unit force along the world's -z seen from the object."""
    for seed in range(100):
        instant = instances.random_instance(np.random.default_rng(seed))
        model = statics(instant)
        if instant.gravity > 0:
            world = instant.contacts.rotation @ model.Q_known[:3]
            np.testing.assert_allclose(world, [0, 0, -1], atol=1e-12)
        else:
            assert not model.Q_known.any()
        assert not model.Q_known[3:].any()


def test_floor_cones_follow_the_world(instances: ModuleType) -> None:
    """Seen from the world, a static floor contact has the same edges at every pose."""
    seen = 0
    for seed in range(200):
        instant = instances.random_instance(np.random.default_rng(seed))
        c = instant.contacts
        up = len(c.normals) > 0 and np.allclose(c.rotation @ c.normals[0], Z, atol=1e-12)
        if not up or c.slip[0].any():
            continue
        s, mu = instant.cone_edges, instant.environment_friction
        edges = c.rotation @ statics(instant).C_env[:3, :s]
        theta = 2 * np.pi / s * np.arange(s)
        np.testing.assert_allclose(edges[0] / edges[2], mu * np.cos(theta), atol=1e-9)
        np.testing.assert_allclose(edges[1] / edges[2], mu * np.sin(theta), atol=1e-9)
        seen += 1
    assert seen > 30
