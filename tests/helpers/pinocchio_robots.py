"""Pinocchio with robodyn's coordinates: joints by name, mimic joints reduced by hand, rates of a free base as ours."""

from __future__ import annotations

import numpy as np

from helpers.peers import pin


class PinocchioRobot:
    """A description that Pinocchio reads with every mimic joint independent; gravity 9.81 down."""

    def __init__(self, source, free=False):
        read = pin.buildModelFromXML if isinstance(source, (bytes, str)) else pin.buildModelFromUrdf
        source = source.decode() if isinstance(source, bytes) else str(source)
        self.model = read(source, pin.JointModelFreeFlyer(), "base") if free else read(source)
        self.data = self.model.createData()

    def state(self, model, q, qd, qdd):
        """Pinocchio's q, v and a of one sample."""
        position, v, a = pin.neutral(self.model), np.zeros(self.model.nv), np.zeros(self.model.nv)
        for body in model.bodies:
            joint = body.joint
            if joint.kind == "fixed":
                continue
            j = self.model.joints[self.model.getJointId(joint.name)]
            if joint.kind == "floating":
                i, k = joint.coordinate, joint.rate
                R = pin.Quaternion(q[i + 3 : i + 7]).toRotationMatrix()
                w, speed = qd[k : k + 3], R.T @ qd[k + 3 : k + 6]
                position[j.idx_q : j.idx_q + 7] = q[i : i + 7]
                v[j.idx_v : j.idx_v + 6] = [*speed, *w]
                a[j.idx_v : j.idx_v + 6] = [*(R.T @ qdd[k + 3 : k + 6] - np.cross(w, speed)), *qdd[k : k + 3]]
                continue
            angle = joint.multiplier * q[joint.coordinate] + joint.offset
            position[j.idx_q : j.idx_q + j.nq] = angle if j.nq == 1 else (np.cos(angle), np.sin(angle))
            v[j.idx_v] = joint.multiplier * qd[joint.rate]
            a[j.idx_v] = joint.multiplier * qdd[joint.rate]
        return position, v, a

    def reduction(self, model, q):
        """S with v = S qd for one sample, so that our tau is S^T tau; a free base's force is in the ground's axes."""
        S = np.zeros((self.model.nv, model.n))
        for body in model.bodies:
            joint = body.joint
            if joint.kind == "fixed":
                continue
            row = self.model.joints[self.model.getJointId(joint.name)].idx_v
            if joint.kind == "floating":
                R = pin.Quaternion(q[joint.coordinate + 3 : joint.coordinate + 7]).toRotationMatrix()
                S[row : row + 3, joint.rate + 3 : joint.rate + 6] = R.T
                S[row + 3 : row + 6, joint.rate : joint.rate + 3] = np.eye(3)
            else:
                S[row, joint.rate] = joint.multiplier
        return S

    def torques(self, model, q, qd, qdd):
        return np.array(
            [
                self.reduction(model, row).T @ pin.rnea(self.model, self.data, *self.state(model, row, *rest))
                for row, *rest in zip(q, qd, qdd, strict=True)
            ]
        )

    def mass_matrices(self, model, q):
        out = []
        for row in q:
            S, still = self.reduction(model, row), np.zeros(model.n)
            M = pin.crba(self.model, self.data, self.state(model, row, still, still)[0])
            out.append(S.T @ (np.triu(M) + np.triu(M, 1).T) @ S)
        return np.array(out)

    def derivatives(self, model, q, qd, qdd):
        """d tau / dq and d tau / d qd of one sample by the chain rule, tau = S^T rnea(position, v, a).

        With R the turn of a free base and a small turn t of it about its own axes: v = R^T v_ground and
        a = R^T a_ground - w x v change by [v] t and ([R^T a_ground] - [w] [v]) t, a force R f by -R [f] t.
        """
        position, v, a = self.state(model, q, qd, qdd)
        pin.computeRNEADerivatives(self.model, self.data, position, v, a)
        data, S = self.data, self.reduction(model, q)
        by_a = np.triu(data.M) + np.triu(data.M, 1).T
        v_by_q, a_by_q, a_by_qd, turned = (np.zeros_like(S) for _ in range(4))
        for joint in (body.joint for body in model.bodies if body.joint.kind == "floating"):
            row, k = self.model.joints[self.model.getJointId(joint.name)].idx_v, joint.rate
            R = pin.Quaternion(q[joint.coordinate + 3 : joint.coordinate + 7]).toRotationMatrix()
            speed, w, turns, shifts = v[row : row + 3], qd[k : k + 3], slice(k, k + 3), slice(k + 3, k + 6)
            v_by_q[row : row + 3, turns] = pin.skew(speed)
            a_by_q[row : row + 3, turns] = pin.skew(R.T @ qdd[shifts]) - pin.skew(w) @ pin.skew(speed)
            a_by_qd[row : row + 3, turns] = pin.skew(speed)
            a_by_qd[row : row + 3, shifts] = -pin.skew(w) @ R.T
            turned[shifts, turns] = -R @ pin.skew(data.tau[row : row + 3])
        dq = S.T @ (data.dtau_dq @ S + data.dtau_dv @ v_by_q + by_a @ a_by_q) + turned[: model.n]
        return dq, S.T @ (data.dtau_dv @ S + by_a @ a_by_qd)

    def wrenches(self, model, q, qd, qdd):
        """(samples, bodies, 6) force and moment on each body about its origin, in its axes."""
        out = []
        for row, *rest in zip(q, qd, qdd, strict=True):
            pin.rnea(self.model, self.data, *self.state(model, row, *rest))
            joints = [body.joint.name for body in model.bodies if body.joint.kind != "fixed"]
            out.append([self.data.f[self.model.getJointId(name)].vector.copy() for name in joints])
        return np.array(out)

    def point_jacobian(self, model, q, frame, point):
        """(6, n) rows: velocity of a point of a link and its angular velocity, both in the ground's axes."""
        position, *_ = self.state(model, q, np.zeros(model.n), np.zeros(model.n))
        pin.computeJointJacobians(self.model, self.data, position)
        pin.updateFramePlacements(self.model, self.data)
        k = self.model.getFrameId(frame)
        J = pin.getFrameJacobian(self.model, self.data, k, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        offset = self.data.oMf[k].rotation @ np.asarray(point, dtype=float)
        J = np.vstack((J[:3] - pin.skew(offset) @ J[3:], J[3:]))
        return J @ self.reduction(model, q), self.data.oMf[k].rotation
