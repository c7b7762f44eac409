import sys,json,time,itertools
sys.path[:0]=['/tmp','/tmp/certs']
from pathlib import Path
from fractions import Fraction
import numpy as np
from scipy.optimize import linprog
import nonsmooth.proofs.systems.system_stability as SS
from nonsmooth.symbolic.files.system_file import build_system
from tests.proofs.system_families import families
from nonsmooth.proofs.checker import lyapunov as L, statements as S
from nonsmooth.proofs.checker.cells import read_system
from nonsmooth.proofs.checker.polynomials import lie_derivative, Polynomial
from nonsmooth.proofs.checker.work import BUDGET
from nonsmooth.proofs.systems.system_certificate import about, exact_text
from writer import Finder, NotShown
from nonsmooth.proofs.many_states.sign_cells import build_cells, surfaces_of
from nonsmooth.symbolic.piecewise import parse_piecewise

def ev(p,pts):
    out=np.zeros(len(pts))
    for e,c in p.terms.items(): out+=float(c)*np.prod(pts**np.array(e),axis=1)
    return out

def find(system, V, radius, degree=3):
    formula=parse_piecewise(V,system.states)
    cells=build_cells(system,system.field(radius),surfaces_of(system,formula))
    sysm=read_system(about(system))
    base={"within":str(radius),"function":V,"surfaces":[str(s) for s in cells.surfaces],"empty":[],"proofs":{}}
    states=system.states
    monos=[e for d in range(1,degree+1) for e in itertools.product(range(d+1),repeat=len(states)) if sum(e)==d]
    texts=["*".join(f"{s}**{k}" for s,k in zip(states,e) if k) for e in monos]
    ly=L.Lyapunov(sysm,{**base})
    rows=[];
    rng=np.random.default_rng(0)
    n=len(states)
    scale=float(radius)
    for cell in ly.inclusion.cells:
        for _,f in cell.fields:
            # candidate points on circles near V'=0
            fall=lie_derivative(cell.functions[0],f)
            P=[]
            for r in [1,.5,.25,.1,.03]:
                th=np.linspace(0,2*np.pi,4001)[:-1]
                pts=r*np.c_[np.cos(th),np.sin(th)]
                g=-ev(fall,pts)
                m=g.max() if g.max()>0 else 1
                ok=np.ones(len(pts),bool)
                for j,s in enumerate(cell.signs):
                    ok&= s*ev(ly.inclusion.surfaces.listed[j],pts)>=-1e-9
                low=ok&(g<=1e-5*m)
                if not fall.terms: low=ok
                P.append(pts[low][::max(1,low.sum()//40)])
            P=np.vstack(P)
            if not len(P): continue
            F=np.c_[tuple(ev(q,P) for q in f)]
            row=np.zeros((len(P),len(monos)))
            for k,e in enumerate(monos):
                mono=Polynomial(n,{e:Fraction(1)})
                row[:,k]=sum(ev(mono.derivative(i),P)*F[:,i] for i in range(n))
            # normalise by size
            rows.append(row/np.maximum(np.abs(row).max(axis=1,keepdims=True),1e-12))
    if not rows: return None,base,'no points'
    A=np.vstack(rows)
    # maximize t: A w >= t, |w|<=1
    k=len(monos)
    res=linprog(np.r_[np.zeros(k),-1],A_ub=np.c_[-A,np.ones(len(A))],b_ub=np.zeros(len(A)),bounds=[(-1,1)]*k+[(0,1)])
    if res.x is None or res.x[-1]<1e-4: return None,base,('margin',None if res.x is None else res.x[-1])
    w=res.x[:k]; terms=[]
    for c,t in zip(w,texts):
        q=Fraction(round(c*16),16)
        if q: terms.append(f"({q})*{t}")
    return "+".join(terms).replace("(-","-1*(") if False else " + ".join(terms),base,res.x[-1]
for i,k in enumerate(families()):
    if i not in (34,35,36,37,1,3,5,29,0,12): continue
    system=build_system({"system":{"states":["x","y"],"rhs":list(k.rhs)},"check":dict(k.check)},"t",Path("t.toml"))
    r=SS.system_check(system)
    V=r.proving and str(SS) and None
    from nonsmooth.proofs.systems.system_facts import proving_text
    if r.proving is not None: V=proving_text(r); radius=Fraction(exact_text(r.domain.radius)) if r.domain.radius is not None else Fraction(1)
    else: V="-(Abs(x)+y**2/2)"; radius=Fraction(1,4)
    for deg in (2,3,4):
        try:
            w,base,info=find(system,V,radius,deg)
        except Exception as e: print(i,'ERR',repr(e)[:100]); break
        if w is None: print(i,k.name,deg,'no W',info); continue
        own={**base,"second":w}
        try:
            ly=L.Lyapunov(read_system(about(system)),own); ly.proofs=Finder(20000)
            ly.show_falls("",ly.zero,strict=False)
            ly.show_leaves()
            print(i,k.name,'V',V,'r',radius,'W',w,'SHOWN',ly.proofs.kinds,flush=True); break
        except NotShown as e: print(i,k.name,deg,V,'W',w,'not shown',e,info,flush=True)
