/* The contact law of kernels/contact.py in plain C: what this machine allows.
 *
 * The same steps for touching pairs (kernels/pairs.py, kernels/contact.py, with friction, rotation, dashpots and the
 * ledger's channels), W pairs side by side: gather, law, scatter.  W = 1 is the scalar loop.  Compiled by
 * scripts/benchmarks/limit/measure.py, which feeds it the contacts of a real bed.
 */
#include <math.h>
#include <string.h>

#ifndef W
#define W 8
#endif
#define EACH for (int l = 0; l < W; ++l)

typedef struct { double x[3], hv[3], hs[3], v[3], s[3], f[3], t[3], listed[3]; } particle;

typedef struct { double radius, R, m, E, G, nd, td, mu, dt; } law;

void contacts(int n, const int *restrict first, const int *restrict second, particle *restrict p,
              double *restrict old_a, double (*restrict xi)[3], const law *restrict L, double *restrict ledger)
{
    const double shear = 8 * L->G, reach = 2 * L->radius, dt = L->dt, h = L->dt;
    for (int c = 0; c + W <= n; c += W) {
        double b[3][W], dv[3][W], dh[3][W], sp[3][W], hs[3][W], o[3][W], oa[W];
        EACH {
            const particle *i = p + first[c + l], *j = p + second[c + l];
            for (int k = 0; k < 3; ++k) {
                b[k][l] = i->x[k] - j->x[k];
                dv[k][l] = i->v[k] - j->v[k];
                dh[k][l] = i->hv[k] - j->hv[k];
                sp[k][l] = i->s[k] + j->s[k];
                hs[k][l] = i->hs[k] + j->hs[k];
                o[k][l] = xi[c + l][k];
            }
            oa[l] = old_a[c + l];
        }
        double f[3][W], q[3][W], a_[W], arm_[W], normal_lost[W], dash_lost[W], slip_lost[W], given[W];
        EACH {
            double d2 = b[0][l] * b[0][l] + b[1][l] * b[1][l] + b[2][l] * b[2][l];
            double d = sqrt(d2), inv = 1 / d, arm = 0.5 * d;
            double nx = b[0][l] * inv, ny = b[1][l] * inv, nz = b[2][l] * inv;
            double overlap = reach - d;
            /* motion */
            double vx = dv[0][l] - arm * (sp[1][l] * nz - sp[2][l] * ny);
            double vy = dv[1][l] - arm * (sp[2][l] * nx - sp[0][l] * nz);
            double vz = dv[2][l] - arm * (sp[0][l] * ny - sp[1][l] * nx);
            double px = dt * inv * dh[0][l], py = dt * inv * dh[1][l], pz = dt * inv * dh[2][l];
            double mx = nx - 0.5 * px, my = ny - 0.5 * py, mz = nz - 0.5 * pz;
            double pm = px * mx + py * my + pz * mz;
            double tx = px - pm * mx, ty = py - pm * my, tz = pz - pm * mz;
            double ux = d * tx - dt * arm * (hs[1][l] * nz - hs[2][l] * ny);
            double uy = d * ty - dt * arm * (hs[2][l] * nx - hs[0][l] * nz);
            double uz = d * tz - dt * arm * (hs[0][l] * ny - hs[1][l] * nx);
            double turn = 0.5 * dt * (hs[0][l] * nx + hs[1][l] * ny + hs[2][l] * nz);
            /* normal */
            double a = sqrt(L->R * overlap), root = sqrt(L->m * a);
            double spring = 4.0 / 3.0 * L->E * a * overlap;
            double approach = -(vx * nx + vy * ny + vz * nz);
            double dash = L->nd * root * approach;
            dash = dash > -spring ? dash : -spring;
            double fn = spring + dash, limit = L->mu * fn;
            normal_lost[l] = dash * approach * h;
            /* tangential spring */
            double kept = oa[l] / a;
            kept = kept < 1 ? kept : 1;
            double gain = 0.5 * (1 + kept);
            double sx = kept * o[0][l] - gain * ux, sy = kept * o[1][l] - gain * uy, sz = kept * o[2][l] - gain * uz;
            double out = sx * nx + sy * ny + sz * nz;
            double gx = sx - out * (nx - 0.5 * tx), gy = sy - out * (ny - 0.5 * ty), gz = sz - out * (nz - 0.5 * tz);
            double one = 1 - 0.5 * turn * turn;
            sx = one * gx + turn * (ny * gz - nz * gy);
            sy = one * gy + turn * (nz * gx - nx * gz);
            sz = one * gz + turn * (nx * gy - ny * gx);
            double k = shear * a, k0 = shear * oa[l];
            double new2 = sx * sx + sy * sy + sz * sz;
            int slides = k * k * new2 > limit * limit;
            double share = slides ? limit / (k * sqrt(new2) + 1e-300) : 1;
            double off = (1 - share) / gain;
            double rx = share * sx, ry = share * sy, rz = share * sz;
            double slip = 0.5 * off * ((k0 * o[0][l] + k * rx) * sx + (k0 * o[1][l] + k * ry) * sy + (k0 * o[2][l] + k * rz) * sz);
            slip_lost[l] = slip > 0 ? slip : 0;
            new2 *= share * share;
            double old2 = o[0][l] * o[0][l] + o[1][l] * o[1][l] + o[2][l] * o[2][l];
            double soft = k0 - k;
            given[l] = soft > 0 ? 0.25 * soft * (old2 + new2) : -0.5 * soft / (k + k0) * (k * new2 + k0 * old2);
            /* dashpot */
            double wx = vx + approach * nx, wy = vy + approach * ny, wz = vz + approach * nz;
            double damping = L->td * root;
            double ex = k * rx, ey = k * ry, ez = k * rz;
            double dx = -damping * wx, dy = -damping * wy, dz = -damping * wz;
            double tot = (ex + dx) * (ex + dx) + (ey + dy) * (ey + dy) + (ez + dz) * (ez + dz);
            double al = ex * dx + ey * dy + ez * dz, v2 = dx * dx + dy * dy + dz * dz;
            double room = limit * limit - (ex * ex + ey * ey + ez * ez);
            room = room > 0 ? room : 0;
            double part = sqrt(al * al + v2 * room) - al;
            part = (part > 0 ? part : 0) / (v2 + 1e-300);
            part = tot > limit * limit ? (part < 1 ? part : 1) : 1;
            dash_lost[l] = part * damping * (wx * wx + wy * wy + wz * wz) * h;
            double fx = fn * nx + ex + part * dx, fy = fn * ny + ey + part * dy, fz = fn * nz + ez + part * dz;
            f[0][l] = fx, f[1][l] = fy, f[2][l] = fz;
            q[0][l] = arm * (fy * nz - fz * ny), q[1][l] = arm * (fz * nx - fx * nz), q[2][l] = arm * (fx * ny - fy * nx);
            o[0][l] = rx, o[1][l] = ry, o[2][l] = rz;
            a_[l] = a, arm_[l] = arm;
        }
        EACH {
            particle *i = p + first[c + l], *j = p + second[c + l];
            for (int k = 0; k < 3; ++k) {
                i->f[k] += f[k][l], j->f[k] -= f[k][l];
                i->t[k] += q[k][l], j->t[k] += q[k][l];
                xi[c + l][k] = o[k][l];
            }
            old_a[c + l] = a_[l];
            ledger[0] += normal_lost[l], ledger[1] += dash_lost[l], ledger[2] += slip_lost[l], ledger[3] += given[l];
        }
    }
}
