"""prototype: writes /2 certificate of a planar result"""
import json, time
from fractions import Fraction
from nonsmooth.proofs.checker import lyapunov as L, statements as S, cells as C
from nonsmooth.proofs.checker.work import RejectedError, BUDGET
from nonsmooth.proofs.checker.cells import read_system
from nonsmooth.proofs.checker.lyapunov import Lyapunov, Proofs, pattern
from nonsmooth.proofs.kernel.simplices import search
from nonsmooth.proofs.kernel import squares
from nonsmooth.proofs.many_states.sign_cells import build_cells, surfaces_of
from nonsmooth.proofs.many_states.empty_patterns import empty_patterns
from nonsmooth.proofs.systems.system_certificate import about, exact_text, with_stated_function
from nonsmooth.proofs.systems.system_facts import proving_pieces, proving_text
from nonsmooth.symbolic.piecewise import parse_piecewise
from conv import convert

class NotShown(Exception): pass

class Finder(Proofs):
    def __init__(self, work): super().__init__({}); self.found={}; self.work=work; self.kinds={}
    def show(self, claim):
        e=search(claim,self.work)
        k='simplices'
        if e is None:
            e=squares.search(claim); k='squares'
        self.kinds[k]=self.kinds.get(k,0)+1
        if e is None:
            import os
            if os.environ.get("DBG"):
                for i in claim.inequalities: print("  p",{k:str(v) for k,v in i.value.terms.items()},"q",[{k:str(v) for k,v in q.terms.items()} for q in i.pushes],"g",{n:{k:str(v) for k,v in g.terms.items()} for n,g in i.guards.items() if n[0]=="s"})
            raise NotShown(claim.name)
        self.found[claim.name]=e
        self.are_forms=self.are_forms and all(o.value.is_form for o in claim.inequalities)

def write(result, work=20000, V=None, radius=0):
    system=result.scene
    subject=about(system)
    pieces=proving_pieces(result)
    extra=[]
    field=system.field
    if V is None:
        radius=result.domain.radius
        within=None if radius is None else exact_text(radius)
        if len(pieces)<=1:
            V=str(pieces[0].potential) if pieces else proving_text(result)
            formula=parse_piecewise(V,system.states)
            more=surfaces_of(system,formula)
        else:
            lines=[]
            def line(ray):
                x,y=[Fraction(exact_text(v)) for v in ray]
                return f"{x}*y - {y}*x".replace('- -','+ ')
            texts={}
            rows=[]
            for p in pieces:
                rows.append((p.start,p.end,str(p.potential)))
            V=rows
            more=[]
            from nonsmooth.symbolic.numbers.polynomial import Polynomial
            X,Y=system.coordinates()
            for a,b,_ in rows:
                for r in (a,b):
                    s=Y*r[0]-X*r[1]
                    more.append(s)
    # normalise surfaces
    rad=radius if radius is not None else system.field(1)
    cells0=build_cells(system,rad,())
    surfs=list(cells0.surfaces)
    def same(a,b):
        return a.degree==b.degree and (not (a*b.leading() - b*a.leading()) if hasattr(a,'leading') else str(a)==str(b))
    keyed={}
    def norm(s):
        t=s.terms; lead=max(t); c=t[lead]
        return frozenset((e,str(v/c)) for e,v in t.items())
    for s in surfs: keyed[norm(s)]=s
    new=[]
    for s in more:
        if norm(s) not in keyed: keyed[norm(s)]=s; new.append(s)
    cells=build_cells(system,rad,new)
    order=[norm(s) for s in cells.surfaces]
    n=len(order)
    if isinstance(V,list):
        table=[]
        for a,b,text in V:
            signs=['.']*n
            for r,side in ((a,1),(b,-1)):
                s=Y*r[0]-X*r[1]
                j=order.index(norm(s))
                lead=max(s.terms); g=cells.surfaces[j]
                flip=1 if (s.terms[lead]/g.terms[lead]).sign()>0 else -1
                signs[j]='+' if side*flip>0 else '-'
            table.append(["".join(signs),text])
        V=table
    empty=[]
    for entry in empty_patterns(cells):
        signs=['.']*n; d={}
        for num,s,w in entry: signs[num]=s; d[num]=Fraction(w)
        last=max(d)
        empty.append({"signs":"".join(signs),"proof":{"mixture":[{f"s{k}":str(v/d[last]) for k,v in d.items() if k!=last and v}]}})
    sysm=read_system(subject)
    own={"within":within,"function":V,"surfaces":[str(s) for s in cells.surfaces],"empty":empty,"proofs":{}}
    ly=Lyapunov(sysm,own)
    ly.proofs=Finder(work)
    verdict=str(result.verdict)
    grows=verdict=='unstable'
    strict=result.proving.verdict.name=='STRICT'
    if grows:
        neg=lambda t: t and f"-({t})"
        own["function"]=neg(V) if isinstance(V,str) else [[m,neg(t)] for m,t in V]
        ly=Lyapunov(sysm,own); ly.proofs=Finder(work)
        ly.show_zero(); ly.show_falls("",ly.zero,strict=True)
        own["proofs"]=ly.proofs.found
        # direction: inner rational direction of some cell
        import itertools
        for d in [(1,0),(0,1),(1,1),(3,5),(-5,3),(7,-4),(-2,-9),(13,-29),(1,-3)]:
            direction=[Fraction(x) for x in d]
            ok=False
            for cell in ly.inclusion.cells:
                if all(L.sign_along(ly.inclusion.surfaces.signed(j,s_),direction)>0 for j,s_ in enumerate(cell.signs)) and L.sign_along(cell.functions[0],direction)<0: ok=True
            if ok: break
        else: raise NotShown('direction')
        ent={"theorem":"instability","hypotheses":{"direction":[str(x) for x in d],"lyapunov":own}}
        return {"version":S.VERSION,"statement":{"subject":subject,"claims":[{"stability":"unstable"}]},"evidence":[ent]}, ly.proofs.kinds
    ly.show_zero(); ly.show_positive(); ly.show_falls("",ly.zero,strict=strict)
    v='asymptotically stable' if strict else 'stable'
    claims=[{"stability":v}]
    about_={"function":V,"within":within}
    level=rate=None; forms=ly.proofs.are_forms
    everywhere=False
    missing=[]
    if strict and result.everywhere:
        try: ly.require_all_of_space(); everywhere=True; claims.append({"attracts":"everywhere"})
        except RejectedError: missing.append('everywhere')
    if strict and within is not None and result.region is not None and result.region.falls:
        level=exact_text(result.region.level)
        try: ly.show_border(Fraction(level)); claims.append({"attracts":{**about_,"below":level}})
        except NotShown: missing.append('level'); level=None
    if strict and result.rate is not None:
        rate={"kind":result.rate.decay.name.lower(),"kappa":exact_text(result.rate.kappa)}
        keep=dict(ly.proofs.found)
        try: L.show_rate(ly,rate); claims.append({"rate":{**about_,**rate}})
        except NotShown as e: missing.append('rate '+str(e)); rate=None; ly.proofs.found=keep
    own["proofs"]=ly.proofs.found
    if missing: print('   MISSING',missing)
    ent={"theorem":"lyapunov","hypotheses":{"verdict":v,"everywhere":everywhere,"level":level,"rate":rate,"lyapunov":own}}
    cert={"version":S.VERSION,"statement":{"subject":subject,"claims":claims},"evidence":[ent]}
    return cert, ly.proofs.kinds
